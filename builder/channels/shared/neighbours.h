// What texels without data borrow: the sums over the 3 x 3 texels around them. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "builder/channels/codec/channel_codec.h"

namespace vt::channels {

// For each of `planes`, the last of which is the weight, the sum over texel `i` of `rows.here` and its eight
// neighbours, added from west to east and north to south in `Real`. Texels that weigh less than
// `least_weight` are left out; weights are never below 0.
template <class Real, std::size_t n>
[[nodiscard]] std::array<Real, n> sum_around(const RowNeighbourhood& rows, const std::array<std::size_t, n>& planes, std::int64_t i,
                                             float least_weight = 0.0F) {
  std::array<Real, n> sum{};
  for (const ConstPlaneRow* row : {&rows.above, &rows.here, &rows.below})
    for (std::int64_t x = i - 1; x <= i + 1; ++x)
      if ((*row)[planes.back()][x] >= least_weight)
        for (std::size_t p = 0; p < n; ++p) sum[p] += static_cast<Real>((*row)[planes[p]][x]);
  return sum;
}

// Planes of a channel with three numbers and their weight.
inline constexpr std::array<std::size_t, 4> kThreeAndWeight{0, 1, 2, 3};

}  // namespace vt::channels
