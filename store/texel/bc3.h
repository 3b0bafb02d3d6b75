// Decodes BC3 (DXT5) blocks exactly: a BC4 block of alpha, then a block of colours that is always in the
// four-colour mode. The store and the runtime need only this direction; encoding is builder/encode's. Pure
// functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::store {

// 16 texels, row by row, RGBA; alpha rounded to the nearest integer.
[[nodiscard]] std::array<std::array<std::uint8_t, 4>, 16> decode_bc3_block(std::span<const std::byte, 16> block);

// A width x height image of blocks (multiples of 4) into rows of RGBA8, tightly packed.
void decode_bc3_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba);

}  // namespace vt::store
