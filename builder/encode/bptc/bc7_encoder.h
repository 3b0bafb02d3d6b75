// Texels to BC7 blocks. Encodes the codes as they are, all four channels of equal worth; which codes to store
// is the channels' business. One block per SIMD lane, run-time dispatch. Pure functions, any thread, no
// allocation; every CPU target makes the same bytes.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// `width` and `height` are multiples of 4. `rgba` holds `height` rows, `row_pitch_bytes` apart, of RGBA of 8
// bits each; the last row may end with its last texel. `blocks` is exactly width * height bytes: rows of
// blocks of 16 bytes, north to south. A block of one colour is exact, and alpha 255 in all of a block stays
// 255. No block's squared error is larger at a higher quality. kFast: one line through the block (mode 6),
// and alpha apart (mode 5). kNormal: also the best-ranked partitions into two subsets (modes 1, 3, 7), 1.5 to
// 4 dB more on photographs. kBest: all eight modes, every rotation.
void encode_bc7_image(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

}  // namespace vt::encode
