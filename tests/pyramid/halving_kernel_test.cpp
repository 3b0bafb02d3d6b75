#include "builder/pyramid/halving_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace vt::pyramid {
namespace {

// Gain at a frequency given in units of the coarse grid's Nyquist frequency, which is a quarter of the fine
// grid's sampling rate.
double gain(const HalvingKernel& kernel, double nyquist) {
  double sum = 0.0;
  for (int t = 0; t < kernel.taps; ++t)
    sum += static_cast<double>(kernel.weight[static_cast<std::size_t>(t)]) *
           std::cos(2 * std::numbers::pi * nyquist / 4 * (t - (kernel.taps - 1) / 2.0));
  return sum;
}

TEST(HalvingKernel, WeightsAreSymmetricAndSumToOneInAnyOrder) {
  for (const HalvingKernel& kernel : all_kernels()) {
    std::vector<float> weights(kernel.weight.begin(), kernel.weight.begin() + kernel.taps);
    for (int t = 0; t < kernel.taps; ++t)
      EXPECT_EQ(weights[static_cast<std::size_t>(t)], weights[static_cast<std::size_t>(kernel.taps - 1 - t)]);
    std::sort(weights.begin(), weights.end());
    for (int i = 0; i < 1000 && std::next_permutation(weights.begin(), weights.end()); ++i) {
      float sum = 0.0F;
      for (float w : weights) sum += w;
      ASSERT_EQ(sum, 1.0F);
    }
  }
}

TEST(HalvingKernel, GainsAreTheBoxsClosedForm) {
  for (double f : {0.25, 0.5, 0.8, 1.2}) EXPECT_NEAR(gain(box_kernel(), f), std::cos(std::numbers::pi * f / 4), 1e-12);
}

// The coarse texels beside a step of the fine ones have the sums of the weights on its far side.
double step_overshoot(const HalvingKernel& kernel) {
  double sum = 0.0;
  double greatest = 0.0;
  for (int t = 0; t < kernel.taps; ++t)
    greatest = std::max(greatest, sum += static_cast<double>(kernel.weight[static_cast<std::size_t>(t)]));
  return greatest - 1.0;
}

// Computed from the kernels' definitions in double precision; rounding the weights to 2^-20 moves a gain or a
// sum by less than 20 * 2^-21 = 1e-5, the rest is the table's own rounding.
TEST(HalvingKernel, GainsAndOvershootAreThoseOfTheDefinitions) {
  struct Row {
    const HalvingKernel& kernel;
    double half_nyquist;
    double near_nyquist;
    double alias;
    double overshoot;
  };
  for (const Row& row : {Row{box_kernel(), 0.9239, 0.8090, 0.5878, 0.0}, Row{mitchell_kernel(), 0.8432, 0.5816, 0.2021, 0.0191},
                         Row{lanczos3_kernel(), 1.0117, 0.8231, 0.1803, 0.0819}, Row{kaiser3_kernel(), 0.9994, 0.8229, 0.1750, 0.0771},
                         Row{kaiser5_kernel(), 0.9937, 0.9506, 0.0487, 0.0905}}) {
    EXPECT_NEAR(gain(row.kernel, 0.0), 1.0, 1e-12) << row.kernel.name;
    EXPECT_NEAR(gain(row.kernel, 0.5), row.half_nyquist, 7e-5) << row.kernel.name;
    EXPECT_NEAR(gain(row.kernel, 0.8), row.near_nyquist, 7e-5) << row.kernel.name;
    EXPECT_NEAR(gain(row.kernel, 1.2), row.alias, 7e-5) << row.kernel.name;
    EXPECT_NEAR(step_overshoot(row.kernel), row.overshoot, 7e-5) << row.kernel.name;
  }
}

TEST(HalvingKernel, NamesAreKnown) {
  EXPECT_EQ(kernel_from_name("box")->taps, 2);
  EXPECT_EQ(kernel_from_name("kaiser3")->taps, 12);
  EXPECT_FALSE(kernel_from_name("lanczos").has_value());
}

}  // namespace
}  // namespace vt::pyramid
