// Errors of many texels, collected. Sums are in double; adding blocks in a fixed order gives the same bits
// whatever thread made them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vt::channels {

struct ErrorSum {
  std::uint64_t count = 0;
  double sum = 0.0;  // of magnitudes
  double sum_squares = 0.0;
  double largest = 0.0;
  // What should be there and what is, where a total has to be kept (light, power, area); otherwise both 0.
  double reference_total = 0.0;
  double stored_total = 0.0;

  void add(double error) {
    const double magnitude = std::abs(error);
    ++count;
    sum += magnitude;
    sum_squares += magnitude * magnitude;
    largest = std::max(largest, magnitude);
  }
  void add_total(double reference, double stored) {
    reference_total += reference;
    stored_total += stored;
  }
  ErrorSum& operator+=(const ErrorSum& other) {
    count += other.count;
    sum += other.sum;
    sum_squares += other.sum_squares;
    largest = std::max(largest, other.largest);
    reference_total += other.reference_total;
    stored_total += other.stored_total;
    return *this;
  }

  // 0 when nothing was measured.
  [[nodiscard]] double mean() const { return count == 0 ? 0.0 : sum / static_cast<double>(count); }
  [[nodiscard]] double root_mean_square() const { return count == 0 ? 0.0 : std::sqrt(sum_squares / static_cast<double>(count)); }
};

}  // namespace vt::channels
