// Angles by sums, products and square roots alone, which round alike on every CPU; the C library's arc
// functions need not. For what is reported and stored of errors. Pure functions, any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vt::channels {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

// asin(x) = x + x^3/6 + 3 x^5/40 + ... of a sine whose square is at most 0.04, where the first term left out
// is 3e-13.
[[nodiscard]] inline double arc_of_small_sine(double sine_squared) {
  constexpr std::array<double, 8> kTerms{1.0,          1.0 / 6,       3.0 / 40,         15.0 / 336,
                                         105.0 / 3456, 945.0 / 42240, 10395.0 / 599040, 135135.0 / 9676800};
  double sum = 0.0;
  for (std::size_t k = kTerms.size(); k-- > 0;) sum = sum * sine_squared + kTerms[k];
  return std::sqrt(sine_squared) * sum;
}

// The angle between two unit vectors in radians, from 0 to pi, to about 1e-12: from their distance, so that
// small angles keep their digits.
[[nodiscard]] inline double angle_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double distance_squared = 0.0;
  for (std::size_t c = 0; c < 3; ++c) distance_squared += (a[c] - b[c]) * (a[c] - b[c]);
  // The sine of half the angle; then, while it is large, of half of that: sin^2(t/2) = sin^2(t) / (2 (1 + cos
  // t)).
  double sine_squared = std::min(0.25 * distance_squared, 1.0);
  double factor = 2.0;
  for (; sine_squared > 0.04; factor *= 2.0) sine_squared /= 2.0 * (1.0 + std::sqrt(1.0 - sine_squared));
  return factor * arc_of_small_sine(sine_squared);
}

}  // namespace vt::channels
