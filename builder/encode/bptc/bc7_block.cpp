#include "builder/encode/bptc/bc7_block.h"

#include <cassert>
#include <cstdlib>
#include <utility>

#include "store/texel/bc7.h"
#include "store/texel/bptc_bits.h"
#include "store/texel/bptc_table.h"

namespace vt::encode {
namespace {

using store::Bc7Mode;
using store::BptcBitWriter;

// One colour: mode 5 with index 1 everywhere, whose 43:21 mixture of two 7-bit codes reaches every 8-bit
// value.
struct CodePair {
  std::uint8_t end0 = 0;
  std::uint8_t end1 = 0;
};
constexpr std::uint32_t expanded7(std::uint32_t code) { return code << 1U | code >> 6U; }
constexpr std::array<CodePair, 256> kSolidCodes = [] {
  std::array<CodePair, 256> pairs{};
  std::array<bool, 256> found{};
  // The closest pair that makes the value, the darker first.
  for (std::uint32_t distance = 0; distance < 4; ++distance) {
    for (std::uint32_t low = 0; low + distance < 128; ++low) {
      for (const auto& [a, b] : {std::pair(low, low + distance), std::pair(low + distance, low)}) {
        const std::uint32_t value = store::bptc_interpolated(expanded7(a), expanded7(b), store::kWeights2[1]);
        if (found[value]) continue;
        found[value] = true;
        pairs[value] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
      }
    }
  }
  return pairs;
}();
static_assert([] {
  for (std::uint32_t v = 0; v < 256; ++v)
    if (store::bptc_interpolated(expanded7(kSolidCodes[v].end0), expanded7(kSolidCodes[v].end1), store::kWeights2[1]) != v) return false;
  return true;
}());

Bc7Choice solid_choice(std::uint32_t color) {
  Bc7Choice choice;
  choice.head = 5;
  for (unsigned shift = 0; shift < 24; shift += 8) {
    const CodePair pair = kSolidCodes[color >> shift & 0xFFU];
    choice.ends[0] |= static_cast<std::uint32_t>(pair.end0) << shift;
    choice.ends[1] |= static_cast<std::uint32_t>(pair.end1) << shift;
  }
  choice.ends[0] |= color & 0xFF000000U;
  choice.ends[1] |= color & 0xFF000000U;
  choice.indices = 0x1111111111111111U;
  return choice;
}

constexpr std::uint64_t kLowestOfEach = 0x1111111111111111U;

// Bits of the indices of one subset: `index_bits` of each of its texels.
std::uint64_t index_mask(const Bc7Mode& mode, std::size_t partition, std::size_t subset, unsigned index_bits) {
  const std::uint64_t one = (1U << index_bits) - 1U;
  if (mode.subsets == 1) return one * kLowestOfEach;
  std::uint64_t mask = 0;
  for (std::size_t i = 0; i < 16; ++i)
    if (store::bptc_subset(mode.subsets, partition, i) == subset) mask |= one << (4 * i);
  return mask;
}

std::size_t anchor(const Bc7Mode& mode, std::size_t partition, std::size_t subset) {
  if (subset == 0) return 0;
  if (mode.subsets == 2) return store::kAnchorOfSecondOfTwo[partition];
  return subset == 1 ? store::kAnchorOfSecondOfThree[partition] : store::kAnchorOfThirdOfThree[partition];
}

// Exchanges the end points of a subset, in the channels of `channel_mask`, where its anchor's index does not
// fit.
void make_anchor_fit(Bc7Choice& choice, std::uint64_t& indices, const Bc7Mode& mode, std::size_t partition, std::size_t subset,
                     unsigned index_bits, std::uint32_t channel_mask) {
  const std::size_t texel = anchor(mode, partition, subset);
  if ((indices >> (4 * texel + index_bits - 1) & 1U) == 0) return;
  indices ^= index_mask(mode, partition, subset, index_bits);
  std::uint32_t& end0 = choice.ends[2 * subset];
  std::uint32_t& end1 = choice.ends[2 * subset + 1];
  const std::uint32_t difference = (end0 ^ end1) & channel_mask;
  end0 ^= difference;
  end1 ^= difference;
  const unsigned shift = Bc7Choice::kLowestBitShift + 2 * static_cast<unsigned>(subset);
  const std::uint32_t unequal = (choice.head >> shift ^ choice.head >> (shift + 1U)) & 1U;
  choice.head ^= unequal * (3U << shift);
}

void put_indices(BptcBitWriter& bits, std::uint64_t indices, const Bc7Mode& mode, std::size_t partition, unsigned index_bits) {
  for (std::size_t i = 0; i < 16; ++i, indices >>= 4U)
    bits.put(indices & 15U, index_bits - (store::bptc_is_anchor(mode.subsets, partition, i) ? 1U : 0U));
}

}  // namespace

void write_bc7_block(const Bc7Choice& chosen, std::span<std::byte, 16> block) {
  Bc7Choice choice = (chosen.head & 15U) == Bc7Choice::kSolid ? solid_choice(chosen.ends[0]) : chosen;
  const unsigned mode_number = choice.head & 15U;
  assert(mode_number < 8);
  const Bc7Mode& mode = store::kBc7Modes[mode_number];
  const std::size_t partition = choice.head >> Bc7Choice::kPartitionShift & 63U;
  const std::uint32_t selection = choice.head >> Bc7Choice::kSelectionShift & 1U;
  unsigned color_index_bits = mode.index_bits;
  unsigned alpha_index_bits = mode.index_bits_more;
  if (selection != 0) std::swap(color_index_bits, alpha_index_bits);
  const std::uint32_t color_channels = mode.index_bits_more != 0 ? 0x00FFFFFFU : 0xFFFFFFFFU;
  for (std::size_t subset = 0; subset < mode.subsets; ++subset)
    make_anchor_fit(choice, choice.indices, mode, partition, subset, color_index_bits, color_channels);
  if (mode.index_bits_more != 0) make_anchor_fit(choice, choice.alpha_indices, mode, partition, 0, alpha_index_bits, 0xFF000000U);

  BptcBitWriter bits;
  bits.put(std::uint64_t{1} << mode_number, mode_number + 1);
  bits.put(partition, mode.partition_bits);
  bits.put(choice.head >> Bc7Choice::kRotationShift & 3U, mode.rotation_bits);
  bits.put(selection, mode.index_selection_bits);
  const std::size_t ends = std::size_t{2} * mode.subsets;
  for (unsigned channel = 0; channel < (mode.alpha_bits != 0 ? 4U : 3U); ++channel)
    for (std::size_t end = 0; end < ends; ++end)
      bits.put(choice.ends[end] >> (8 * channel) & 0xFFU, channel < 3 ? mode.color_bits : mode.alpha_bits);
  for (std::size_t end = 0; mode.p_bits != 0 && end < ends; end += mode.p_bits == 1 ? 2 : 1)
    bits.put(choice.head >> (Bc7Choice::kLowestBitShift + end) & 1U, 1);
  if (mode.index_bits_more == 0) {
    put_indices(bits, choice.indices, mode, partition, mode.index_bits);
  } else {
    put_indices(bits, selection == 0 ? choice.indices : choice.alpha_indices, mode, partition, mode.index_bits);
    put_indices(bits, selection == 0 ? choice.alpha_indices : choice.indices, mode, partition, mode.index_bits_more);
  }
  assert(bits.size() == 128);
  bits.store(block);
}

}  // namespace vt::encode
