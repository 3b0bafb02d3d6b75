// Where BC6H keeps its fields: the fourteen modes of the Khronos data format specification 1.3, section 20.2, table "Block formats for
// BC6H", in that table's own notation. The decoder and the encoder both read it, so they cannot differ.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vt::store {

// End points are w and x of subset 0, y and z of subset 1. Where the mode is transformed, w has `base_bits` and the others are differences
// to w, signed, of `delta_bits`; where not, all have `base_bits`.
struct Bc6hMode {
  std::uint8_t code;     // the first bits of the block: 2 of them when below 2, else 5
  std::uint8_t subsets;  // 1: indices of 4 bits; 2: of 3 bits, after 5 bits of partition
  bool transformed;
  std::uint8_t base_bits;
  std::array<std::uint8_t, 3> delta_bits;  // red, green, blue
  // Fields after the mode in their order from low to high bits. `rw9:0` is bits 0 to 9, the lowest first; `rw10:11` bit 11 first.
  std::string_view fields;

  [[nodiscard]] constexpr unsigned code_bits() const { return code < 2 ? 2 : 5; }
};

inline constexpr std::array<Bc6hMode, 14> kBc6hModes{{
    {0, 2, true, 10, {5, 5, 5},
     "gy4 by4 bz4 rw9:0 gw9:0 bw9:0 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3"},
    {1, 2, true, 7, {6, 6, 6},
     "gy5 gz4 gz5 rw6:0 bz0 bz1 by4 gw6:0 by5 bz2 gy4 bw6:0 bz3 bz5 bz4 rx5:0 gy3:0 gx5:0 gz3:0 bx5:0 by3:0 ry5:0 rz5:0"},
    {2, 2, true, 11, {5, 4, 4},
     "rw9:0 gw9:0 bw9:0 rx4:0 rw10 gy3:0 gx3:0 gw10 bz0 gz3:0 bx3:0 bw10 bz1 by3:0 ry4:0 bz2 rz4:0 bz3"},
    {6, 2, true, 11, {4, 5, 4},
     "rw9:0 gw9:0 bw9:0 rx3:0 rw10 gz4 gy3:0 gx4:0 gw10 gz3:0 bx3:0 bw10 bz1 by3:0 ry3:0 bz0 bz2 rz3:0 gy4 bz3"},
    {10, 2, true, 11, {4, 4, 5},
     "rw9:0 gw9:0 bw9:0 rx3:0 rw10 by4 gy3:0 gx3:0 gw10 bz0 gz3:0 bx4:0 bw10 by3:0 ry3:0 bz1 bz2 rz3:0 bz4 bz3"},
    {14, 2, true, 9, {5, 5, 5},
     "rw8:0 by4 gw8:0 gy4 bw8:0 bz4 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3"},
    {18, 2, true, 8, {6, 5, 5},
     "rw7:0 gz4 by4 gw7:0 bz2 gy4 bw7:0 bz3 bz4 rx5:0 gy3:0 gx4:0 bz0 gz3:0 bx4:0 bz1 by3:0 ry5:0 rz5:0"},
    {22, 2, true, 8, {5, 6, 5},
     "rw7:0 bz0 by4 gw7:0 gy5 gy4 bw7:0 gz5 bz4 rx4:0 gz4 gy3:0 gx5:0 gz3:0 bx4:0 bz1 by3:0 ry4:0 bz2 rz4:0 bz3"},
    {26, 2, true, 8, {5, 5, 6},
     "rw7:0 bz1 by4 gw7:0 by5 gy4 bw7:0 bz5 bz4 rx4:0 gz4 gy3:0 gx4:0 bz0 gz3:0 bx5:0 by3:0 ry4:0 bz2 rz4:0 bz3"},
    {30, 2, false, 6, {6, 6, 6},
     "rw5:0 gz4 bz0 bz1 by4 gw5:0 gy5 by5 bz2 gy4 bw5:0 gz5 bz3 bz5 bz4 rx5:0 gy3:0 gx5:0 gz3:0 bx5:0 by3:0 ry5:0 rz5:0"},
    {3, 1, false, 10, {10, 10, 10},
     "rw9:0 gw9:0 bw9:0 rx9:0 gx9:0 bx9:0"},
    {7, 1, true, 11, {9, 9, 9},
     "rw9:0 gw9:0 bw9:0 rx8:0 rw10 gx8:0 gw10 bx8:0 bw10"},
    {11, 1, true, 12, {8, 8, 8},
     "rw9:0 gw9:0 bw9:0 rx7:0 rw10:11 gx7:0 gw10:11 bx7:0 bw10:11"},
    {15, 1, true, 16, {4, 4, 4},
     "rw9:0 gw9:0 bw9:0 rx3:0 rw10:15 gx3:0 gw10:15 bx3:0 bw10:15"},
}};

// One bit of a block: bit `bit` of channel `channel` (red, green, blue) of end point `end` (w, x, y, z).
struct Bc6hPlace {
  std::uint8_t channel;
  std::uint8_t end;
  std::uint8_t bit;
};
struct Bc6hLayout {
  std::array<Bc6hPlace, 75> places{};
  std::size_t count = 0;
};

// The notation above, bit by bit.
constexpr Bc6hLayout bc6h_layout(std::string_view fields) {
  Bc6hLayout layout;
  std::size_t at = 0;
  const auto number = [&] {
    int value = 0;
    while (at < fields.size() && fields[at] >= '0' && fields[at] <= '9') value = value * 10 + (fields[at++] - '0');
    return value;
  };
  while (at < fields.size()) {
    const char channel = fields[at++];
    const auto end = static_cast<std::uint8_t>(fields[at] == 'w' ? 0 : fields[at] - 'x' + 1);
    ++at;
    const int last = number();
    int first = last;
    if (at < fields.size() && fields[at] == ':') {
      ++at;
      first = number();
    }
    // Written high:low for a run upwards; low:high for one downwards.
    const int step = first <= last ? 1 : -1;
    for (int bit = first;; bit += step) {
      layout.places[layout.count++] = {static_cast<std::uint8_t>(channel == 'r'   ? 0
                                                                 : channel == 'g' ? 1
                                                                                  : 2),
                                       end, static_cast<std::uint8_t>(bit)};
      if (bit == last) break;
    }
    ++at;  // the space
  }
  return layout;
}

inline constexpr std::array<Bc6hLayout, 14> kBc6hLayouts = [] {
  std::array<Bc6hLayout, 14> layouts;
  for (std::size_t mode = 0; mode < 14; ++mode) layouts[mode] = bc6h_layout(kBc6hModes[mode].fields);
  return layouts;
}();

// Every block is full: mode, fields, partition and indices (one bit less for each anchor) are 128 bits.
static_assert([] {
  for (std::size_t mode = 0; mode < 14; ++mode) {
    const Bc6hMode& m = kBc6hModes[mode];
    const std::size_t rest = m.subsets == 2 ? 5 + 16 * 3 - 2 : 16 * 4 - 1;
    if (m.code_bits() + kBc6hLayouts[mode].count + rest != 128) return false;
  }
  return true;
}());

}  // namespace vt::store
