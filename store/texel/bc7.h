// Decodes BC7 (BPTC unorm) blocks exactly, all eight modes, as the Khronos data format specification 1.3,
// section 20.1, defines them. The store and the runtime need only this direction; encoding is
// builder/encode's. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

// What a mode's blocks hold. Bits of colour and alpha are per channel and end point, without the shared
// lowest bit ("p-bit").
struct Bc7Mode {
  std::uint8_t subsets;
  std::uint8_t partition_bits;
  std::uint8_t rotation_bits;
  std::uint8_t index_selection_bits;
  std::uint8_t color_bits;
  std::uint8_t alpha_bits;       // 0: alpha is 255
  std::uint8_t p_bits;           // of each subset: none, one for both end points, or one for each
  std::uint8_t index_bits;       // of colour, and of alpha where there is no second index
  std::uint8_t index_bits_more;  // of the second index; 0: there is none
};
inline constexpr std::array<Bc7Mode, 8> kBc7Modes{{
    {3, 4, 0, 0, 4, 0, 2, 3, 0},
    {2, 6, 0, 0, 6, 0, 1, 3, 0},
    {3, 6, 0, 0, 5, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 2, 2, 0},
    {1, 0, 2, 1, 5, 6, 0, 2, 3},
    {1, 0, 2, 0, 7, 8, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 2, 4, 0},
    {2, 6, 0, 0, 5, 5, 2, 2, 0},
}};

// 16 texels, row by row, RGBA. A block of the reserved mode (first byte 0) is transparent black.
using Bc7Texels = std::array<std::array<std::uint8_t, 4>, 16>;
[[nodiscard]] Bc7Texels decode_bc7_block(std::span<const std::byte, 16> block);

// A width x height image of blocks (multiples of 4) into rows of RGBA8, tightly packed.
void decode_bc7_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba);

}  // namespace vt::store
