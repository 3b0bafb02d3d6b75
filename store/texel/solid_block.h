// Blocks of one colour in the two formats whose blocks cannot be enlarged by their indices: what
// block_enlarger.h puts in their place. Exact: the decoders give back the colour. Everything else about
// encoding is builder/encode's. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vt::store {

// `rgba` is 0 to 255 each.
[[nodiscard]] std::array<std::byte, 16> solid_bc7_block(const std::array<std::uint8_t, 4>& rgba);
// `rgb` are the bits of finite halves that are not negative.
[[nodiscard]] std::array<std::byte, 16> solid_bc6h_block(const std::array<std::uint16_t, 3>& rgb);

}  // namespace vt::store
