// What a channel writes for a layer that is stored in blocks: the texels that builder/encode's encoders take. Any thread.
#pragma once

#include "store/texel_format.h"

namespace vt::channels {

// rgb8 for bc1, rgba8 for bc3 and bc7, r16 for bc4 and rg16 for bc5 (65535 stands for the 255 that is decoded), rgba16f for bc6h. A plain
// format is its own.
[[nodiscard]] constexpr TexelFormat unblocked_format(TexelFormat format) {
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

}  // namespace vt::channels
