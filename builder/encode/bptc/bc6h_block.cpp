#include "builder/encode/bptc/bc6h_block.h"

#include <cassert>
#include <utility>

#include "store/texel/bc6h_table.h"
#include "store/texel/bptc_bits.h"
#include "store/texel/bptc_table.h"

namespace vt::encode {

void write_bc6h_block(const Bc6hChoice& chosen, std::span<std::byte, 16> block) {
  Bc6hChoice choice = chosen;
  const store::Bc6hMode& mode = store::kBc6hModes[choice.mode];
  const unsigned index_bits = mode.subsets == 1 ? 4 : 3;
  for (std::size_t subset = 0; subset < mode.subsets; ++subset) {
    const std::size_t anchor = subset == 0 ? 0 : store::kAnchorOfSecondOfTwo[choice.partition];
    if ((choice.indices >> (4 * anchor + index_bits - 1) & 1U) == 0) continue;
    std::swap(choice.ends[2 * subset], choice.ends[2 * subset + 1]);
    const std::uint64_t all = (1U << index_bits) - 1U;
    for (std::size_t i = 0; i < 16; ++i)
      if (store::bptc_subset(mode.subsets, choice.partition, i) == subset) choice.indices ^= all << (4 * i);
  }

  if (mode.transformed) {
    for (std::size_t end = 1; end < 4; ++end) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t difference = choice.ends[end][c] - choice.ends[0][c];
        [[maybe_unused]] const std::uint32_t limit = 1U << (mode.delta_bits[c] - 1U);
        assert(end / 2 >= mode.subsets || difference + limit < 2 * limit);
        choice.ends[end][c] = difference;
      }
    }
  }

  store::BptcBitWriter bits;
  bits.put(mode.code, mode.code_bits());
  const store::Bc6hLayout& layout = store::kBc6hLayouts[choice.mode];
  for (std::size_t i = 0; i < layout.count; ++i) {
    const store::Bc6hPlace& place = layout.places[i];
    bits.put(choice.ends[place.end][place.channel] >> place.bit & 1U, 1);
  }
  if (mode.subsets == 2) bits.put(choice.partition, 5);
  for (std::size_t i = 0; i < 16; ++i)
    bits.put(choice.indices >> (4 * i) & 15U, index_bits - (store::bptc_is_anchor(mode.subsets, choice.partition, i) ? 1U : 0U));
  assert(bits.size() == 128);
  bits.store(block);
}

}  // namespace vt::encode
