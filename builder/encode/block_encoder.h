// Texels to blocks of any block-compressed format: the one place that knows which encoder belongs to which.
// Pure functions, any thread.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"
#include "store/texel_format.h"

namespace vt::encode {

// `texels`: `height` rows of `width` texels of format_info(format).encoded_from, `row_pitch_bytes` apart;
// both sizes are multiples of 4. `format` is a block format. `blocks` has exactly their size.
void encode_blocks(TexelFormat format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, Quality quality, std::span<std::byte> blocks);

}  // namespace vt::encode
