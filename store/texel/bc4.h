// Decodes BC4 and BC5 (RGTC, 3Dc) blocks exactly, unsigned only: Khronos data format specification section
// 19. A BC4 block is also the alpha half of a BC3 block. The store and the runtime need only this direction;
// encoding is builder/encode's. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

// 16 texels, row by row, 0..255: end points are whole, the values between them are sevenths or fifths,
// correctly rounded to float.
[[nodiscard]] std::array<float, 16> decode_bc4_block(std::span<const std::byte, 8> block);
// The same, rounded to the nearest integer (there are no ties).
[[nodiscard]] std::array<std::uint8_t, 16> decode_bc4_block_u8(std::span<const std::byte, 8> block);

// Two channels, each a BC4 block: red first.
[[nodiscard]] std::array<std::array<float, 2>, 16> decode_bc5_block(std::span<const std::byte, 16> block);

// A width x height image of blocks (multiples of 4), 8 bytes a block (BC4) or 16 (BC5), into rows of texels,
// tightly packed: one value a texel (BC4) or red and green interleaved (BC5). Bytes are rounded to nearest,
// floats are on the scale 0..255.
void decode_bc4_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> r8);
void decode_bc4_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<float> r);
void decode_bc5_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rg8);
void decode_bc5_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<float> rg);

}  // namespace vt::store
