#include "builder/encode/block_encoder.h"

#include <cassert>

#include "builder/encode/bc1_encoder.h"
#include "builder/encode/bc4_encoder.h"

namespace vt::encode {

TexelFormat unblocked_format(TexelFormat format) {
  switch (format) {
    case TexelFormat::kBc1:
      return TexelFormat::kRgb8;
    case TexelFormat::kBc3:
    case TexelFormat::kBc7:
      return TexelFormat::kRgba8;
    case TexelFormat::kBc4:
      return TexelFormat::kR16;
    case TexelFormat::kBc5:
      return TexelFormat::kRg16;
    case TexelFormat::kBc6h:
      return TexelFormat::kRgba16Float;
    default:
      return format;
  }
}

void encode_blocks(TexelFormat format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, Quality quality, std::span<std::byte> blocks) {
  switch (format) {
    case TexelFormat::kBc1:
      return encode_bc1_image(texels, width, height, row_pitch_bytes, 3, blocks);
    case TexelFormat::kBc4:
      return encode_bc4_image(texels, width, height, row_pitch_bytes, quality, blocks);
    case TexelFormat::kBc5:
      return encode_bc5_image(texels, width, height, row_pitch_bytes, quality, blocks);
    default:
      assert(false && "a format without an encoder");
  }
}

}  // namespace vt::encode
