// The bits of a BC6H block from what an encoder chose for it. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::encode {

struct Bc6hChoice {
  std::uint32_t mode = 10;      // row of store::kBc6hModes
  std::uint32_t partition = 0;  // modes of two subsets
  // Codes of the end points in the mode's base bits: [end][channel], two ends of subset 0, then of subset 1.
  // In a transformed mode any two of them differ by less than half of what the differences can hold, so that
  // their order does not matter.
  std::array<std::array<std::uint32_t, 3>, 4> ends{};
  std::uint64_t indices = 0;  // of texel i in bits 4 i
};

// Indices of an anchor texel may have their highest bit set: the end points are then exchanged.
void write_bc6h_block(const Bc6hChoice& choice, std::span<std::byte, 16> block);

}  // namespace vt::encode
