// Decodes BC6H blocks of the unsigned format (BPTC unsigned float) exactly, all fourteen modes, as the
// Khronos data format specification 1.3, section 20.2, defines them: to the bits of IEEE 754 binary16, never
// negative, at most 65504. The store and the runtime need only this direction; encoding is builder/encode's.
// Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

// 16 texels, row by row, the half bits of R, G, B. A block of a reserved mode is black.
using Bc6hTexels = std::array<std::array<std::uint16_t, 3>, 16>;
[[nodiscard]] Bc6hTexels decode_bc6h_block(std::span<const std::byte, 16> block);

// A width x height image of blocks (multiples of 4) into rows of RGBA of halves, little-endian, tightly
// packed, 8 bytes a texel; alpha is 1.
void decode_bc6h_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba16f);

}  // namespace vt::store
