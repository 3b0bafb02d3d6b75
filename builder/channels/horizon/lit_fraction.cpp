#include "builder/channels/horizon/lit_fraction.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace vt::channels {
namespace {

constexpr std::size_t kStepsPerUnit = 128;
constexpr double kLargest = 6.0;  // beyond, 1 to within 1e-9
constexpr std::size_t kEntries = static_cast<std::size_t>(kLargest) * kStepsPerUnit + 2;

// e^x, for small numbers.
constexpr double exponential(double x) {
  double term = 1.0;
  double sum = 1.0;
  for (int k = 1; k < 12; ++k) sum += term *= x / k;
  return sum;
}

// Phi at multiples of a step h, by Simpson's rule over each step. The density at multiples of d = h / 2 comes
// from one to the next: g(k + 1) / g(k) = exp(-(2 k + 1) d^2 / 2), which itself falls by the factor
// exp(-d^2).
constexpr std::array<double, kEntries> distribution_table() {
  constexpr double h = 1.0 / kStepsPerUnit;
  constexpr double d = 0.5 * h;
  const double ratio_falls_by = exponential(-d * d);
  double ratio = exponential(-0.5 * d * d);
  double density = std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  std::array<double, kEntries> table{};
  table[0] = 0.5;
  for (std::size_t i = 1; i < kEntries; ++i) {
    const double left = density;
    const double middle = left * ratio;
    ratio *= ratio_falls_by;
    density = middle * ratio;
    ratio *= ratio_falls_by;
    table[i] = table[i - 1] + h / 6.0 * (left + 4.0 * middle + density);
  }
  return table;
}

constexpr std::array<double, kEntries> kDistribution = distribution_table();

}  // namespace

double normal_distribution(double z) {
  const double magnitude = std::abs(z);
  if (magnitude >= kLargest) return z > 0.0 ? 1.0 : 0.0;
  const double place = magnitude * kStepsPerUnit;
  const auto entry = static_cast<std::size_t>(place);
  const double above = kDistribution[entry] + (place - static_cast<double>(entry)) * (kDistribution[entry + 1] - kDistribution[entry]);
  return z < 0.0 ? 1.0 - above : above;
}

}  // namespace vt::channels
