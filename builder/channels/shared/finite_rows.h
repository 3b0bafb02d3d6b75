// Whether numbers of a row are finite. Any thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace vt::channels {

// No infinity and no NaN among `count` numbers. Sums of finite samples overflow to infinity.
[[nodiscard]] inline bool all_finite(const float* values, std::int64_t count) {
  constexpr std::uint32_t kMagnitude = 0x7FFFFFFF;
  constexpr std::uint32_t kInfinity = 0x7F800000;
  // Magnitudes of floats are in the order of their bits.
  std::uint32_t largest = 0;
  for (std::int64_t i = 0; i < count; ++i) largest = std::max(largest, std::bit_cast<std::uint32_t>(values[i]) & kMagnitude);
  return largest < kInfinity;
}

}  // namespace vt::channels
