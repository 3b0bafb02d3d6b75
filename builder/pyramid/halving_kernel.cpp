#include "builder/pyramid/halving_kernel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace vt::pyramid {
namespace {

// Modified Bessel function of the first kind, order 0, by its power series; converges for the small arguments
// used here.
double bessel_i0(double x) {
  double term = 1.0;
  double sum = 1.0;
  for (int k = 1; k < 64; ++k) {
    term *= (x / (2.0 * k)) * (x / (2.0 * k));
    sum += term;
  }
  return sum;
}

double sinc(double x) { return std::sin(std::numbers::pi * x) / (std::numbers::pi * x); }

double kaiser(double x, double width) {
  constexpr double kAlpha = 4.0;
  return sinc(x) * bessel_i0(kAlpha * std::sqrt(1.0 - (x / width) * (x / width))) / bessel_i0(kAlpha);
}

double mitchell(double x) {
  constexpr double kB = 1.0 / 3.0;
  constexpr double kC = 1.0 / 3.0;
  if (x < 1.0) return ((12.0 - 9.0 * kB - 6.0 * kC) * x * x * x + (-18.0 + 12.0 * kB + 6.0 * kC) * x * x + (6.0 - 2.0 * kB)) / 6.0;
  return ((-kB - 6.0 * kC) * x * x * x + (6.0 * kB + 30.0 * kC) * x * x + (-12.0 * kB - 48.0 * kC) * x + (8.0 * kB + 24.0 * kC)) / 6.0;
}

// `shape` at the taps, in coarse texels from the centre, normalised and rounded.
HalvingKernel make_kernel(std::string_view name, int taps, const std::function<double(double)>& shape) {
  constexpr double kStep = 1.0 / (1 << 20);
  const auto half_taps = static_cast<std::size_t>(taps / 2);
  std::array<double, kMaxTaps / 2> half{};  // taps from the centre outward
  double sum = 0.0;
  for (std::size_t i = 0; i < half_taps; ++i) {
    half[i] = shape(0.25 + 0.5 * static_cast<double>(i));
    sum += 2.0 * half[i];
  }
  double rounded_sum = 0.0;
  for (std::size_t i = 0; i < half_taps; ++i) {
    half[i] = std::round(half[i] / sum / kStep) * kStep;
    rounded_sum += 2.0 * half[i];
  }
  half[0] += (1.0 - rounded_sum) / 2.0;  // the rest of the rounding, a few 2^-20

  HalvingKernel kernel{.name = name, .taps = taps, .weight = {}};
  for (std::size_t i = 0; i < half_taps; ++i) kernel.weight[half_taps - 1 - i] = kernel.weight[half_taps + i] = static_cast<float>(half[i]);
  return kernel;
}

const std::array<HalvingKernel, 6>& kernels() {
  static const std::array<HalvingKernel, 6> made{
      HalvingKernel{.name = "box", .taps = 2, .weight = {0.5F, 0.5F}},
      make_kernel("kaiser3", 12, [](double x) { return kaiser(x, 3.0); }),
      make_kernel("kaiser5", 20, [](double x) { return kaiser(x, 5.0); }),
      make_kernel("lanczos3", 12, [](double x) { return sinc(x) * sinc(x / 3.0); }),
      make_kernel("mitchell", 8, mitchell),
      HalvingKernel{.name = "point", .taps = 2, .weight = {0.5F, 0.5F}, .is_point = true},
  };
  return made;
}

}  // namespace

bool HalvingKernel::has_negative_lobes() const {
  return std::any_of(weight.begin(), weight.begin() + taps, [](float w) { return w < 0.0F; });
}

const HalvingKernel& box_kernel() { return kernels()[0]; }
const HalvingKernel& kaiser3_kernel() { return kernels()[1]; }
const HalvingKernel& kaiser5_kernel() { return kernels()[2]; }
const HalvingKernel& lanczos3_kernel() { return kernels()[3]; }
const HalvingKernel& mitchell_kernel() { return kernels()[4]; }
const HalvingKernel& point_kernel() { return kernels()[5]; }

std::span<const HalvingKernel> all_kernels() { return kernels(); }

std::optional<HalvingKernel> kernel_from_name(std::string_view name) {
  for (const HalvingKernel& kernel : kernels())
    if (kernel.name == name) return kernel;
  return std::nullopt;
}

}  // namespace vt::pyramid
