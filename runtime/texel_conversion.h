// Block formats decoded on their way to a graphics card that does not take them. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <span>

#include "store/texel_format.h"

namespace vt::runtime {

// What the texels of a format are decoded to: RGBA8, R8, RG8 or RGBA16F for the block formats, and themselves for all others.
[[nodiscard]] TexelFormat decoded_format(TexelFormat format);

// A width x height image (multiples of 4) of a block format into rows of its decoded format, tightly packed. To the nearest code where a
// decoded value lies between two.
void decode_blocks(TexelFormat format, std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> out);

}  // namespace vt::runtime
