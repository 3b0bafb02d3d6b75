#include "builder/encode/block_encoder.h"

#include <cassert>

#include "builder/encode/bc1_encoder.h"

namespace vt::encode {

void encode_blocks(TexelFormat format, TexelFormat texel_format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, std::span<std::byte> blocks) {
  assert(format == TexelFormat::kBc1);
  if (format == TexelFormat::kBc1)
    encode_bc1_image(texels, width, height, row_pitch_bytes, format_info(texel_format).block_bytes, blocks);
}

}  // namespace vt::encode
