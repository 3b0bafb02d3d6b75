// What a channel writes for a layer that is stored in blocks: the texels that builder/encode's encoders take.
// Any thread.
#pragma once

#include "store/texel_format.h"

namespace vt::channels {

// A plain format is its own; see FormatInfo::encoded_from.
[[nodiscard]] constexpr TexelFormat unblocked_format(TexelFormat format) { return format_info(format).encoded_from; }

}  // namespace vt::channels
