// Texels of half floats to blocks of the unsigned BC6H format. The error that is made small is the squared
// difference of half codes, the integers behind positive halves: 1024 of them are one octave, so the same
// relative error weighs the same in a dark and in a bright block. Beside that, the sum of linear light of
// each channel in a block is kept: after least squares the end points move, at the least cost in squared
// error, to where the decoded sum is the source's; of several candidates the one is taken that costs least,
// light included; and at last single codes of its ends step to where it costs less. One block per SIMD lane,
// run-time dispatch. Pure functions, any thread, no allocation; every CPU target makes the same bytes.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// `width` and `height` are multiples of 4. `rgba16f` holds `height` rows, `row_pitch_bytes` apart, of RGBA of
// little-endian halves, 8 bytes a texel; alpha is ignored. The last row may end with its last texel. Negative
// numbers and NaN count as 0, infinity as 65504. `blocks` is exactly width * height bytes: rows of blocks of
// 16 bytes, north to south. A block of one colour is exact. kFast: one subset, in the finest mode that holds
// it. kNormal and kBest: also the best-ranked one or six partitions into two subsets. A block that spans more
// than four octaves has 10 bits for each end: a hot texel in the dark may be off by 1.6 %.
void encode_bc6h_image(std::span<const std::byte> rgba16f, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                       Quality quality, std::span<std::byte> blocks);

}  // namespace vt::encode
