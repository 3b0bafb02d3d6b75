// Angles by sums, products and square roots alone, which round alike on every CPU; the C library's arc functions need not. For what is
// reported and stored of errors. Pure functions, any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vt::channels {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

// The angle between two unit vectors in radians, from 0 to pi, to about 1e-12: from their distance, so that small angles keep their digits.
[[nodiscard]] inline double angle_between(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double distance_squared = 0.0;
  for (std::size_t c = 0; c < 3; ++c) distance_squared += (a[c] - b[c]) * (a[c] - b[c]);
  // The sine of half the angle, then of halves of halves: sin^2(t/2) = sin^2(t) / (2 (1 + cos t)).
  double sine_squared = std::min(0.25 * distance_squared, 1.0);
  double factor = 2.0;
  for (int halving = 0; halving < 3; ++halving, factor *= 2.0) sine_squared /= 2.0 * (1.0 + std::sqrt(1.0 - sine_squared));
  // asin(x) = x + x^3/6 + 3 x^5/40 + ...; x is at most sin(pi / 16) = 0.2, where the first term left out is 3e-13.
  const double x = std::sqrt(sine_squared);
  double term = x;
  double sum = x;
  for (int k = 1; k <= 7; ++k) {
    term *= sine_squared * (2 * k - 1) / (2 * k);
    sum += term / (2 * k + 1);
  }
  return factor * sum;
}

}  // namespace vt::channels
