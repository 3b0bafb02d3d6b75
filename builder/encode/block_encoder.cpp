#include "builder/encode/block_encoder.h"

#include <cassert>

#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/encode/bc1/bc3_encoder.h"
#include "builder/encode/bc4/bc4_encoder.h"
#include "builder/encode/bptc/bc6h_encoder.h"
#include "builder/encode/bptc/bc7_encoder.h"

namespace vt::encode {

void encode_blocks(TexelFormat format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, Quality quality, std::span<std::byte> blocks) {
  switch (format) {
    case TexelFormat::kBc1:
      return encode_bc1_image(texels, width, height, row_pitch_bytes, 3, quality, blocks);
    case TexelFormat::kBc3:
      return encode_bc3_image(texels, width, height, row_pitch_bytes, quality, blocks);
    case TexelFormat::kBc4:
      return encode_bc4_image(texels, width, height, row_pitch_bytes, quality, blocks);
    case TexelFormat::kBc5:
      return encode_bc5_image(texels, width, height, row_pitch_bytes, quality, blocks);
    case TexelFormat::kBc6h:
      return encode_bc6h_image(texels, width, height, row_pitch_bytes, quality, blocks);
    case TexelFormat::kBc7:
      return encode_bc7_image(texels, width, height, row_pitch_bytes, quality, blocks);
    default:
      assert(false && "a format without an encoder");
  }
}

}  // namespace vt::encode
