// The bits of a BC7 block from what an encoder chose for it. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vt::encode {

// What was chosen, in few words because the encoder keeps a vector of each: one block per lane.
struct Bc7Choice {
  // Mode in bits 0-3, partition 4-9, rotation 10-11, index selection 12, lowest bit of end point n in
  // bit 16 + n. Mode 8 stands for one colour in the whole block, given in ends[0] by its 8-bit values.
  std::uint32_t head = 0;
  // Codes of two end points for each subset, without their lowest shared bit: red in bits 0-7, then green,
  // blue, alpha. In modes with a rotation the codes are of the channels after it: alpha is the one with
  // indices of its own.
  std::array<std::uint32_t, 6> ends{};
  // Index of texel i in bits 4 i; of colour, and of alpha in the modes that have two.
  std::uint64_t indices = 0;
  std::uint64_t alpha_indices = 0;

  static constexpr std::uint32_t kSolid = 8;
  static constexpr unsigned kPartitionShift = 4, kRotationShift = 10, kSelectionShift = 12, kLowestBitShift = 16;
};

// Indices of an anchor texel may have their highest bit set: the end points are then exchanged.
void write_bc7_block(const Bc7Choice& choice, std::span<std::byte, 16> block);

}  // namespace vt::encode
