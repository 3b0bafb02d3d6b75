// For every 8-bit value, the pair of end point codes whose 2:1 mixture decodes nearest to it: the best that
// BC1 can do for a block of one colour. Constants made at compile time; beside its one user, bc1_encoder.cpp.
#pragma once

#include <array>
#include <cstdint>

namespace vt::encode {

struct SingleColor {
  std::uint8_t end0;   // code of the end point that weighs 2/3
  std::uint8_t end1;   // code of the other
  std::uint8_t value;  // what they decode to
};

// `bits` is 5 or 6. Among equally near pairs the closest two end points win: decoders that round thirds
// otherwise then differ least.
template <int bits>
constexpr std::array<SingleColor, 256> make_single_color_table() {
  constexpr int kCodes = 1 << bits;
  constexpr int kNone = 1000;
  std::array<SingleColor, 256> table{};
  std::array<int, 256> spread{};
  spread.fill(kNone);

  // First the values that some pair hits exactly ...
  for (int end0 = 0; end0 < kCodes; ++end0) {
    for (int end1 = 0; end1 < kCodes; ++end1) {
      const int a = end0 << (8 - bits) | end0 >> (2 * bits - 8);
      const int b = end1 << (8 - bits) | end1 >> (2 * bits - 8);
      const int value = (2 * a + b + 1) / 3;
      const int distance = a > b ? a - b : b - a;
      if (distance < spread[value]) {
        spread[value] = distance;
        table[value] = {static_cast<std::uint8_t>(end0), static_cast<std::uint8_t>(end1), static_cast<std::uint8_t>(value)};
      }
    }
  }
  // ... then the others take the nearest of those.
  for (int value = 0; value < 256; ++value) {
    if (spread[value] != kNone) continue;
    for (int step = 1; step < 256; ++step) {
      const bool below = value - step >= 0 && spread[value - step] != kNone;
      const bool above = value + step < 256 && spread[value + step] != kNone;
      if (!below && !above) continue;
      table[value] = table[below ? value - step : value + step];
      break;
    }
  }
  return table;
}

}  // namespace vt::encode
