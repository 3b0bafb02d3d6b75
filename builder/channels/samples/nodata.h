// Which samples equal a declared no-data value. Files declare it as decimal text, often with fewer digits
// than their samples have, or as a number that the samples' type cannot hold; the rules are those of GDAL
// 3.6, on which the writers of such files rely. Any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "builder/channels/samples/sample_layout.h"
#include "builder/source/sample_type.h"

namespace vt::channels {

// Samples from `low` to `high`, both included; none when low > high.
struct NodataRange {
  double low = 1.0;
  double high = 0.0;
  [[nodiscard]] bool empty() const { return !(low <= high); }
  [[nodiscard]] bool contains(double sample) const { return sample >= low && sample <= high; }
};

// - Integers: the declared value without its fraction (bytes: only a whole value), if the type holds it.
// - Floating point: samples whose relative distance is below about 4.8e-7, a few steps of a 32-bit float, in
// samples of 64 bits as well:
//   these are often floats that were widened.
// - A value within a thousandth of the type's (or the 32-bit float's) largest number stands for "the lowest
// number there is", however many
//   digits were written: all samples of its sign from 1e38 (1e308) on are no data.
// - NaN and infinities: no finite sample; samples that are not finite never are data.
[[nodiscard]] NodataRange nodata_range(SampleType type, double declared);

// The same for samples of the C++ type T, which is that of `type`.
template <class T>
struct TypedNodataRange {
  T low = 1;
  T high = 0;
  [[nodiscard]] bool empty() const { return !(low <= high); }
  [[nodiscard]] bool contains(T sample) const { return sample >= low && sample <= high; }
};

template <class T>
[[nodiscard]] TypedNodataRange<T> typed_nodata_range(SampleType type, double declared) {
  const NodataRange range = nodata_range(type, declared);
  if (range.empty()) return {};
  if constexpr (std::is_same_v<T, float>) {
    float low = static_cast<float>(range.low);
    float high = static_cast<float>(range.high);
    if (static_cast<double>(low) < range.low) low = std::nextafter(low, std::numeric_limits<float>::max());
    if (static_cast<double>(high) > range.high) high = std::nextafter(high, std::numeric_limits<float>::lowest());
    return {low, high};
  } else {
    return {static_cast<T>(range.low), static_cast<T>(range.high)};
  }
}

// The range of one band of a layout; empty when nothing is declared.
template <class T>
[[nodiscard]] TypedNodataRange<T> typed_nodata_range(const SampleLayout& layout, std::size_t band = 0) {
  return layout.nodata ? typed_nodata_range<T>(layout.type, layout.nodata->of(band)) : TypedNodataRange<T>{};
}
[[nodiscard]] inline NodataRange nodata_range(const SampleLayout& layout, std::size_t band = 0) {
  return layout.nodata ? nodata_range(layout.type, layout.nodata->of(band)) : NodataRange{};
}

}  // namespace vt::channels
