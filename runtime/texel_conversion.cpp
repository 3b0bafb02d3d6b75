#include "runtime/texel_conversion.h"

#include <cassert>

#include "store/texel/bc1.h"
#include "store/texel/bc3.h"
#include "store/texel/bc4.h"
#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"

namespace vt::runtime {

TexelFormat decoded_format(TexelFormat format) {
  switch (format) {
    case TexelFormat::kBc1:
    case TexelFormat::kBc3:
    case TexelFormat::kBc7:
      return TexelFormat::kRgba8;
    case TexelFormat::kBc4:
      return TexelFormat::kR8;
    case TexelFormat::kBc5:
      return TexelFormat::kRg8;
    case TexelFormat::kBc6h:
      return TexelFormat::kRgba16Float;
    default:
      return format;
  }
}

void decode_blocks(TexelFormat format, std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> out) {
  switch (format) {
    case TexelFormat::kBc1:
      return store::decode_bc1_image(blocks, width, height, out);
    case TexelFormat::kBc3:
      return store::decode_bc3_image(blocks, width, height, out);
    case TexelFormat::kBc4:
      return store::decode_bc4_image(blocks, width, height, out);
    case TexelFormat::kBc5:
      return store::decode_bc5_image(blocks, width, height, out);
    case TexelFormat::kBc6h:
      return store::decode_bc6h_image(blocks, width, height, out);
    case TexelFormat::kBc7:
      return store::decode_bc7_image(blocks, width, height, out);
    default:
      assert(false);
  }
}

}  // namespace vt::runtime
