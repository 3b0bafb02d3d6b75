#include "builder/pyramid/halving_kernel.h"

#include <cmath>
#include <numbers>

namespace vt::pyramid {
namespace {

// Modified Bessel function of the first kind, order 0, by its power series; converges for the small arguments used here.
double bessel_i0(double x) {
  double term = 1.0;
  double sum = 1.0;
  for (int k = 1; k < 64; ++k) {
    term *= (x / (2.0 * k)) * (x / (2.0 * k));
    sum += term;
  }
  return sum;
}

HalvingKernel make_kaiser3() {
  constexpr double kAlpha = 4.0;
  constexpr double kWidth = 3.0;
  constexpr double kStep = 1.0 / (1 << 20);
  std::array<double, 6> half{};  // taps from the centre outward
  double sum = 0.0;
  for (std::size_t i = 0; i < half.size(); ++i) {
    const double x = 0.25 + 0.5 * static_cast<double>(i);
    const double sinc = std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    half[i] = sinc * bessel_i0(kAlpha * std::sqrt(1.0 - (x / kWidth) * (x / kWidth))) / bessel_i0(kAlpha);
    sum += 2.0 * half[i];
  }
  double rounded_sum = 0.0;
  for (double& weight : half) {
    weight = std::round(weight / sum / kStep) * kStep;
    rounded_sum += 2.0 * weight;
  }
  half[0] += (1.0 - rounded_sum) / 2.0;  // the rest of the rounding, a few 2^-20

  HalvingKernel kernel{.name = "kaiser3", .taps = 12, .weight = {}};
  for (std::size_t i = 0; i < half.size(); ++i) kernel.weight[5 - i] = kernel.weight[6 + i] = static_cast<float>(half[i]);
  return kernel;
}

}  // namespace

const HalvingKernel& box_kernel() {
  static const HalvingKernel kernel{.name = "box", .taps = 2, .weight = {0.5F, 0.5F}};
  return kernel;
}

const HalvingKernel& kaiser3_kernel() {
  static const HalvingKernel kernel = make_kaiser3();
  return kernel;
}

std::optional<HalvingKernel> kernel_from_name(std::string_view name) {
  if (name == box_kernel().name) return box_kernel();
  if (name == kaiser3_kernel().name) return kaiser3_kernel();
  return std::nullopt;
}

}  // namespace vt::pyramid
