#include "builder/encode/bc1/bc3_encoder.h"

#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/encode/bc4/bc4_encoder.h"

namespace vt::encode {

void encode_bc3_image(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks) {
  encode_bc3_alpha(rgba, width, height, row_pitch_bytes, quality, blocks);
  encode_bc3_color(rgba, width, height, row_pitch_bytes, quality, blocks);
}

}  // namespace vt::encode
