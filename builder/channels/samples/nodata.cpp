#include "builder/channels/samples/nodata.h"

namespace vt::channels {
namespace {

template <class T>
NodataRange of_integer(double declared) {
  if (!std::isfinite(declared) || (sizeof(T) == 1 && declared != std::trunc(declared))) return {};
  const double whole = std::trunc(declared);
  const bool fits =
      whole >= static_cast<double>(std::numeric_limits<T>::lowest()) && whole <= static_cast<double>(std::numeric_limits<T>::max());
  return fits ? NodataRange{whole, whole} : NodataRange{};
}

// Around `centre`, which is finite.
NodataRange of_float(double centre, double largest) {
  constexpr double kLargestFloat = std::numeric_limits<float>::max();
  const double size = std::abs(centre);
  NodataRange range;
  if (largest > kLargestFloat && size > 0.999 * largest) {
    range = {1e308, largest};
  } else if (size > 0.999 * kLargestFloat && size < 1.001 * kLargestFloat) {
    range = {1e38, std::min(largest, 1.001 * kLargestFloat)};
  } else {
    // |sample - centre| < 2 e |sample + centre|, with e the distance from 1 to the next float.
    constexpr double kReach = 2.0 * std::numeric_limits<float>::epsilon();
    constexpr double kRatio = (1.0 - kReach) / (1.0 + kReach);
    range = {size * kRatio, std::min(size / kRatio, largest)};
  }
  return centre < 0.0 ? NodataRange{-range.high, -range.low} : range;
}

}  // namespace

bool NodataKey::operator==(const NodataKey& other) const {
  const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  return std::equal(values_.begin(), values_.end(), other.values_.begin(), other.values_.end(), same);
}

NodataRange nodata_range(SampleType type, double declared) {
  return visit_sample_type(type, [&]<class T>(std::type_identity<T>) -> NodataRange {
    if constexpr (std::is_integral_v<T>) return of_integer<T>(declared);
    if (!std::isfinite(declared)) return {};
    constexpr auto kLargest = static_cast<double>(std::numeric_limits<T>::max());
    return of_float(static_cast<double>(static_cast<T>(std::clamp(declared, -kLargest, kLargest))), kLargest);
  });
}

}  // namespace vt::channels
