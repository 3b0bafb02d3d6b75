// Texels with alpha to BC3 blocks: a BC4 block of alpha (bc4_encoder.h) and a four-colour block
// (bc1_encoder.h), whose promises hold here. Pure function, any thread, no allocation; every CPU target makes
// the same bytes.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// `width` and `height` are multiples of 4. `rgba` holds `height` rows, `row_pitch_bytes` apart, of R G B A, 8
// bits each, alpha not multiplied in. Colours under alpha 0 do not change a block, except where all of its
// texels have alpha 0. `blocks` is exactly width / 4 * height / 4 * 16 bytes: rows of blocks, north to south.
void encode_bc3_image(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

}  // namespace vt::encode
