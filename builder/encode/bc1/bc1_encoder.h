// Texels to BC1 blocks, always in the opaque four-colour mode, and colours to the second half of BC3 blocks.
// Encodes the codes as they are; which codes to store is the channels' business. One block per SIMD lane,
// run-time dispatch. Pure functions, any thread, no allocation; every CPU target makes the same bytes.
//
//   kFast    the principal axis and one pass of least squares.
//   kNormal  the best of five passes from three starts.
//   kBest    all partitions of the texels along the line into four runs (cluster fit), then the codes around; no block has a larger error
//            than kNormal's.
// A block of one colour has the least possible error at every quality.
#pragma once

#include <cstddef>
#include <span>

#include "builder/encode/quality.h"

namespace vt::encode {

// `width` and `height` are multiples of 4. `rgb` holds `height` rows, `row_pitch_bytes` apart, of texels of
// `bytes_per_texel` bytes: 3 is R G B, 4 is R G B and a byte that is ignored. The last row may end with its
// last texel. `blocks` is exactly width / 4 * height / 4 * 8 bytes: rows of blocks, north to south.
void encode_bc1_image(std::span<const std::byte> rgb, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                      std::size_t bytes_per_texel, Quality quality, std::span<std::byte> blocks);
inline void encode_bc1_image(std::span<const std::byte> rgb, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                             std::size_t bytes_per_texel, std::span<std::byte> blocks) {
  encode_bc1_image(rgb, width, height, row_pitch_bytes, bytes_per_texel, Quality::kNormal, blocks);
}

// Texels R G B A, 8 bits each, into the last 8 bytes of each 16-byte block; the others are left alone. Texels
// of alpha 0 have no say in the colours, unless all 16 have alpha 0: then all have.
void encode_bc3_color(std::span<const std::byte> rgba, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                      std::span<std::byte> blocks);

}  // namespace vt::encode
