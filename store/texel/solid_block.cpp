#include "store/texel/solid_block.h"

#include <cassert>
#include <span>

#include "store/texel/bc6h_table.h"
#include "store/texel/bptc_bits.h"
#include "store/texel/bptc_table.h"

namespace vt::store {
namespace {

// BC7's mode 5: one subset, end points of 7 bits a colour channel, expanded by repeating the leading one, and
// of 8 bits for alpha; no rotation; two bits of index for the colour, two for alpha.
constexpr unsigned kMode5 = 5;
constexpr std::uint32_t kIndex = 1;

struct EndPoints {
  std::uint8_t first = 0;
  std::uint8_t second = 0;
};

// For every value a pair of 7-bit end points between which index 1 gives it. Even values below 128 and odd
// ones above have an end point of their own; two neighbours give those between.
constexpr std::array<EndPoints, 256> kEndPoints = [] {
  std::array<EndPoints, 256> table = {};
  const auto expanded = [](std::uint32_t code) { return code << 1U | code >> 6U; };
  std::array<bool, 256> is_known = {};
  for (std::uint32_t first = 0; first < 128; ++first) {
    for (std::uint32_t second = first; second < 128 && second < first + 4; ++second) {
      const std::uint32_t value = bptc_interpolated(expanded(first), expanded(second), bptc_weight(2, kIndex));
      if (is_known[value]) continue;
      is_known[value] = true;
      table[value] = {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second)};
    }
  }
  for (const bool known : is_known)
    if (!known) throw "a value that index 1 of no pair gives";  // fails to compile
  return table;
}();

}  // namespace

std::array<std::byte, 16> solid_bc7_block(const std::array<std::uint8_t, 4>& rgba) {
  BptcBitWriter bits;
  bits.put(1U << kMode5, kMode5 + 1);
  bits.put(0, 2);  // rotation
  for (std::size_t c = 0; c < 3; ++c) {
    bits.put(kEndPoints[rgba[c]].first, 7);
    bits.put(kEndPoints[rgba[c]].second, 7);
  }
  bits.put(rgba[3], 8);
  bits.put(rgba[3], 8);
  // The first texel's index has its upper bit left out.
  bits.put(kIndex, 1);
  for (int texel = 1; texel < 16; ++texel) bits.put(kIndex, 2);
  bits.put(0, 31);  // indices of alpha
  assert(bits.size() == 128);
  std::array<std::byte, 16> block;
  bits.store(block);
  return block;
}

// The mode of one subset whose first end point has all 16 bits; the second is the same, 0 away from it. The
// decoder takes code * 31 / 64, rounded down: the least code that comes to the half is half * 64 / 31,
// rounded up.
std::array<std::byte, 16> solid_bc6h_block(const std::array<std::uint16_t, 3>& rgb) {
  constexpr std::size_t kMode = [] {
    for (std::size_t mode = 0; mode < kBc6hModes.size(); ++mode)
      if (kBc6hModes[mode].base_bits == 16) return mode;
    throw "no mode of 16 bits";
  }();
  BptcBitWriter bits;
  bits.put(kBc6hModes[kMode].code, 5);
  const Bc6hLayout& layout = kBc6hLayouts[kMode];
  for (std::size_t i = 0; i < layout.count; ++i) {
    const Bc6hPlace& place = layout.places[i];
    const std::uint32_t code = (std::uint32_t{rgb[place.channel]} * 64 + 30) / 31;
    bits.put(place.end == 0 ? code >> place.bit & 1U : 0U, 1);
  }
  std::array<std::byte, 16> block;
  bits.store(block);  // the indices that follow are all 0
  return block;
}

}  // namespace vt::store
