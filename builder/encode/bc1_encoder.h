// Texels to BC1 blocks, always in the opaque four-colour mode. Encodes the codes as they are; which codes to store is the channels'
// business. One block per SIMD lane, run-time dispatch. Pure functions, any thread, no allocation; every CPU target makes the same bytes.
#pragma once

#include <cstddef>
#include <span>

namespace vt::encode {

// `width` and `height` are multiples of 4. `rgb` holds `height` rows, `row_pitch_bytes` apart, of texels of `bytes_per_texel` bytes:
// 3 is R G B, 4 is R G B and a byte that is ignored. The last row may end with its last texel.
// `blocks` is exactly width / 4 * height / 4 * 8 bytes: rows of blocks, north to south.
void encode_bc1_image(std::span<const std::byte> rgb, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                      std::size_t bytes_per_texel, std::span<std::byte> blocks);

}  // namespace vt::encode
