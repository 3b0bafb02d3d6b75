// Texels to blocks of any block-compressed format: the one place that knows which encoder belongs to which. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "store/texel_format.h"

namespace vt::encode {

// `texels`: `height` rows of `width` texels of `texel_format`, `row_pitch_bytes` apart; both sizes are multiples of 4. `format` is a block
// format, and `texel_format` one that its encoder takes: rgb8 or rgba8 for bc1. `blocks` has exactly their size.
void encode_blocks(TexelFormat format, TexelFormat texel_format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, std::span<std::byte> blocks);

}  // namespace vt::encode
