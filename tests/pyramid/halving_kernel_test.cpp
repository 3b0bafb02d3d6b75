#include "builder/pyramid/halving_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace vt::pyramid {
namespace {

// Gain at a frequency given in units of the coarse grid's Nyquist frequency, which is a quarter of the fine grid's sampling rate.
double gain(const HalvingKernel& kernel, double nyquist) {
  double sum = 0.0;
  for (int t = 0; t < kernel.taps; ++t)
    sum += static_cast<double>(kernel.weight[static_cast<std::size_t>(t)]) *
           std::cos(2 * std::numbers::pi * nyquist / 4 * (t - (kernel.taps - 1) / 2.0));
  return sum;
}

TEST(HalvingKernel, WeightsAreSymmetricAndSumToOneInAnyOrder) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()}) {
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

TEST(HalvingKernel, KaiserIsFlatInTheBandAndLetsFewAliasesThrough) {
  // From the definition of the window; rounding the weights to 2^-20 moves a gain by less than 12 * 2^-21 = 6e-6.
  EXPECT_NEAR(gain(kaiser3_kernel(), 0.0), 1.0, 1e-12);
  EXPECT_NEAR(gain(kaiser3_kernel(), 0.5), 0.999, 5e-4);
  EXPECT_NEAR(gain(kaiser3_kernel(), 0.8), 0.823, 5e-4);
  EXPECT_NEAR(gain(kaiser3_kernel(), 1.2), 0.175, 5e-4);
}

TEST(HalvingKernel, NamesAreKnown) {
  EXPECT_EQ(kernel_from_name("box")->taps, 2);
  EXPECT_EQ(kernel_from_name("kaiser3")->taps, 12);
  EXPECT_FALSE(kernel_from_name("lanczos").has_value());
}

}  // namespace
}  // namespace vt::pyramid
