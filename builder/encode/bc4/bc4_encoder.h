// Texels of one or two scalar channels to BC4 and BC5 blocks, and alpha to the first half of BC3 blocks.
// Samples are 16 bits wide, so end points and indices are chosen against the values before rounding to 8
// bits. One block per SIMD lane, run-time dispatch. Pure functions, any thread, no allocation; every CPU
// target makes the same bytes.
//
// The error that is minimised is the sum of squared differences to the exact values of the decoder
// (store/texel/bc4.h), not to their roundings.
//   kFast    the block's extremes, rounded to codes, and the nearest of the eight values for each texel.
//   kNormal  least squares from several starts and a search of the codes around, in the mode of eight values; and, where texels are near
//            0 or 255, in the mode of six values with 0 and 255.
//   kBest    the optimum: no pair of end points, in either mode, has an error that is smaller by more than float rounding, one part in
//            100 000. Among equals the eight-value mode, then the smallest distance of the end points, then the lowest wins.
// A block whose texels are all the same 8-bit value is exact at every quality.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// `r16` holds `height` rows, `row_pitch_bytes` apart, of `width` native 16-bit integers of any alignment;
// 0..65535 stand for 0..255 on the decoder's scale (257 steps a code). `width` and `height` are multiples of
// 4. The last row may end with its last texel. `blocks` is exactly width / 4 * height / 4 * 8 bytes: rows of
// blocks, north to south.
void encode_bc4_image(std::span<const std::byte> r16, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

// The same for two interleaved channels; 16 bytes a block, the first channel's half first.
void encode_bc5_image(std::span<const std::byte> rg16, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

// Alpha of texels R G B A, 8 bits each, into the first 8 bytes of each 16-byte block; the others are left
// alone.
void encode_bc3_alpha(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

}  // namespace vt::encode
