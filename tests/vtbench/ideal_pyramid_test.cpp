#include "tools/vtbench/measure/ideal_pyramid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace vt::bench {
namespace {

// A horizontal wave of `cycles` per texel, around 0.5.
LightImage wave(std::int64_t size, double cycles, double phase) {
  LightImage image{size, size, {}};
  for (auto& plane : image.planes)
    for (std::int64_t y = 0; y < size; ++y)
      for (std::int64_t x = 0; x < size; ++x)
        plane.push_back(0.5 + 0.4 * std::cos(2.0 * std::numbers::pi * cycles * (static_cast<double>(x) + 0.5) + phase));
  return image;
}

// Away from the edges, where the mirror would show.
double worst_difference(const LightImage& a, const LightImage& b) {
  double worst = 0.0;
  for (std::int64_t x = 20; x < a.width - 20; ++x) {
    const auto i = static_cast<std::size_t>(a.height / 2 * a.width + x);
    worst = std::max(worst, std::abs(a.planes[0][i] - b.planes[0][i]));
  }
  return worst;
}

TEST(HalveIdeally, KeepsAConstant) {
  LightImage flat{64, 32, {}};
  for (auto& plane : flat.planes) plane.assign(64 * 32, 0.3);
  const LightImage half = halve_ideally(flat);
  EXPECT_EQ(half.width, 32);
  EXPECT_EQ(half.height, 16);
  for (const double value : half.planes[1]) EXPECT_NEAR(value, 0.3, 1e-14);
}

// The claim in the header: -60 dB is 0.001 of the amplitude 0.4. A coarse texel covers two fine ones, so its
// centre sees twice the cycles.
TEST(HalveIdeally, PassesWhatTheCoarseGridCanHoldAndStopsTheRest) {
  for (const double of_new_nyquist : {0.1, 0.5, 0.88}) {
    const double cycles = 0.25 * of_new_nyquist;
    EXPECT_LT(worst_difference(halve_ideally(wave(256, cycles, 0.3)), wave(128, 2.0 * cycles, 0.3)), 0.0004) << of_new_nyquist;
  }
  for (const double of_new_nyquist : {1.12, 1.5, 1.9}) {
    LightImage grey = wave(128, 0.0, std::numbers::pi / 2);  // 0.5 everywhere
    EXPECT_LT(worst_difference(halve_ideally(wave(256, 0.25 * of_new_nyquist, 0.3)), grey), 0.0004) << of_new_nyquist;
  }
}

// A wave in an exact pyramid keeps its phase and shrinks by the kernel's response, which the taps alone
// decide.
TEST(HalveExactly, ScalesAWaveByTheResponseOfTheTaps) {
  for (const char* kernel : {"box", "kaiser3"}) {
    const auto taps = kernel_taps(kernel);
    ASSERT_TRUE(taps.has_value());
    const double cycles = 0.11;
    double response = 0.0;
    for (std::size_t t = 0; t < taps->size(); ++t)
      response += static_cast<double>((*taps)[t]) *
                  std::cos(2.0 * std::numbers::pi * cycles * (static_cast<double>(t) - (static_cast<double>(taps->size()) - 1.0) / 2.0));
    const LightImage half = halve_exactly(wave(128, cycles, 0.4), *taps);
    LightImage wanted = wave(64, 2.0 * cycles, 0.4);
    for (double& value : wanted.planes[0]) value = 0.5 + (value - 0.5) * response;
    EXPECT_LT(worst_difference(half, wanted), 1e-14) << kernel;
  }
}

TEST(HalveExactly, TapsAreSymmetricAndSumToOneAndTheBoxIsTheMeanOfFour) {
  const auto kaiser = kernel_taps("kaiser3").value();
  ASSERT_EQ(kaiser.size(), 12U);
  long double sum = 0.0L;
  for (std::size_t t = 0; t < 12; ++t) {
    EXPECT_EQ(kaiser[t], kaiser[11 - t]);
    sum += kaiser[t];
  }
  EXPECT_NEAR(static_cast<double>(sum), 1.0, 1e-18);
  EXPECT_FALSE(kernel_taps("lanczos").has_value());
  LightImage four{2, 2, {}};
  for (auto& plane : four.planes) plane = {0.0, 1.0, 0.25, 0.5};
  EXPECT_EQ(halve_exactly(four, kernel_taps("box").value()).planes[2], (std::vector<double>{0.4375}));
}

TEST(HalveCodes, RoundsTheMeanOfFour) {
  const std::vector<std::uint8_t> rgb = {0, 1, 255, 0, 2, 255, 1, 2, 255, 0, 2, 254};
  EXPECT_EQ(halve_codes(rgb, 2, 2), (std::vector<std::uint8_t>{0, 2, 255}));
}

TEST(PyramidError, OneCodeOffIs48DecibelsAndNothingOffIsInfinite) {
  const std::vector<std::uint8_t> wanted(32 * 32 * 3, 128);
  const std::vector<std::uint8_t> off(32 * 32 * 3, 129);
  const double expected_db = 20.0 * std::log10(255.0);
  EXPECT_NEAR(psnr_of_codes_db(off, wanted), expected_db, 1e-12);
  EXPECT_TRUE(std::isinf(psnr_of_codes_db(wanted, wanted)));

  PyramidError error;
  error.add_level(off, light_from_codes(wanted, 32, 32), 4);
  EXPECT_NEAR(error.psnr_code_db(), expected_db, 1e-9);
  EXPECT_NEAR(error.worst_code_error(), 1.0, 1e-9);
  // The slope of the transfer function at code 128.5 and one code: ((c + 0.055) / 1.055)^1.4 * 2.4 / 1.055 /
  // 255.
  const double step = std::pow((128.5 / 255.0 + 0.055) / 1.055, 1.4) * 2.4 / 1.055 / 255.0;
  EXPECT_NEAR(error.psnr_linear_db(), -20.0 * std::log10(step), 0.001);
  const double light = std::pow((128.0 / 255.0 + 0.055) / 1.055, 2.4);
  EXPECT_NEAR(error.worst_drift_percent(), 100.0 * step / light, 0.01);
}

TEST(PyramidError, LeavesOutTheMarginAndKeepsTheWorstLevelsDrift) {
  const std::vector<std::uint8_t> wanted(16 * 16 * 3, 100);
  std::vector<std::uint8_t> edge_off = wanted;
  for (std::size_t i = 0; i < 16 * 3; ++i) edge_off[i] = 0;  // the first row
  const LightImage ideal = light_from_codes(wanted, 16, 16);
  PyramidError error;
  error.add_level(edge_off, ideal, 1);
  EXPECT_TRUE(std::isinf(error.psnr_linear_db()));
  error.add_level(edge_off, ideal, 0);
  const double with_edge = error.worst_drift_percent();
  EXPECT_NEAR(with_edge, -100.0 / 16.0, 1e-9);
  error.add_level(wanted, ideal, 0);
  EXPECT_EQ(error.worst_drift_percent(), with_edge);
}

TEST(PyramidError, ClampsTheIdealToWhatCodesCanHold) {
  LightImage ringing{2, 2, {}};
  for (auto& plane : ringing.planes) plane = {-0.05, 1.05, -0.05, 1.05};
  std::vector<std::uint8_t> best;
  for (int texel = 0; texel < 4; ++texel) best.insert(best.end(), 3, texel % 2 == 0 ? 0 : 255);
  PyramidError error;
  error.add_level(best, ringing, 0);
  EXPECT_TRUE(std::isinf(error.psnr_linear_db()));
}

}  // namespace
}  // namespace vt::bench
