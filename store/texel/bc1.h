// Decodes BC1 (DXT1) blocks exactly: end points by bit replication, thirds rounded to nearest, as the
// reference in the Khronos data format specification section 18.1. The store and the runtime need only this
// direction; encoding is builder/encode's. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

// 16 texels, row by row, RGBA.
using Bc1Texels = std::array<std::array<std::uint8_t, 4>, 16>;
// The order of the two colours chooses the mode: color0 > color1 is four opaque colours, otherwise three and
// transparent black.
[[nodiscard]] Bc1Texels decode_bc1_block(std::span<const std::byte, 8> block);
// The colour half of a BC3 block: the same bits, but four opaque colours whatever the order.
[[nodiscard]] Bc1Texels decode_four_color_block(std::span<const std::byte, 8> block);

// A width x height image of blocks (multiples of 4) into rows of RGBA8, tightly packed.
void decode_bc1_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba);

}  // namespace vt::store
