#include "builder/channels/normal/normal_rows.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/cpu_targets.h"

namespace vt::channels {
namespace {

class NormalRows : public test::OnEveryCpuTarget {};

// Lengths around every vector width, so that loops and their remainders meet all values.
std::vector<float> hostile_values(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const std::vector<float> special{
      0.0F, -0.0F, 1e30F, -3e38F, 1e-40F, 1e-31F, 1e-29F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
      1.0F};
  std::vector<float> values(count);
  for (float& v : values) v = random() % 4 == 0 ? special[random() % special.size()] : normal(random);
  return values;
}

TEST_P(NormalRows, UnitVectorsFollowTheDefinitionBitForBit) {
  for (std::size_t count : {0U, 1U, 3U, 4U, 7U, 16U, 17U, 1000U}) {
    const auto x0 = hostile_values(count, 1);
    const auto y0 = hostile_values(count, 2);
    const auto z0 = hostile_values(count, 3);
    auto x = x0;
    auto y = y0;
    auto z = z0;
    std::vector<float> weight(count, 5.0F);
    const float least = 1e-30F;
    const bool all = make_unit(count, least, x.data(), y.data(), z.data(), weight.data());
    bool all_wanted = true;
    for (std::size_t i = 0; i < count; ++i) {
      float wx = 0.0F;
      float wy = 0.0F;
      float wz = 0.0F;
      float w = 0.0F;
      const float largest = std::max({std::abs(x0[i]), std::abs(y0[i]), std::abs(z0[i])});
      if (std::isfinite(x0[i]) && std::isfinite(y0[i]) && std::isfinite(z0[i]) && largest >= least) {
        const float sx = x0[i] / largest;
        const float sy = y0[i] / largest;
        const float sz = z0[i] / largest;
        const float length = std::sqrt(sx * sx + sy * sy + sz * sz);
        wx = sx / length;
        wy = sy / length;
        wz = sz / length;
        w = 1.0F;
      }
      all_wanted = all_wanted && w == 1.0F;
      EXPECT_EQ(std::bit_cast<std::uint32_t>(x[i]), std::bit_cast<std::uint32_t>(wx)) << count << " " << i;
      EXPECT_EQ(y[i], wy) << i;
      EXPECT_EQ(z[i], wz) << i;
      EXPECT_EQ(weight[i], w) << i;
    }
    EXPECT_EQ(all, all_wanted) << count;
  }
}

TEST_P(NormalRows, DirectionAndLengthFollowTheDefinitionBitForBit) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-1.0F, 1.0F);
  for (std::size_t count : {1U, 5U, 8U, 19U, 700U}) {
    std::vector<float> x(count);
    std::vector<float> y(count);
    std::vector<float> z(count);
    std::vector<float> w(count);
    for (std::size_t i = 0; i < count; ++i) {
      w[i] = random() % 5 == 0 ? 0.0F : random() % 3 == 0 ? 1.0F : std::abs(any(random)) + 1e-3F;
      const float size = w[i] * (random() % 4 == 0 ? 1e-4F : 0.57F);
      x[i] = size * any(random);
      y[i] = size * any(random);
      z[i] = size * any(random);
    }
    std::vector<float> dx(count), dy(count), dz(count), length(count);
    direction_and_length(count, x.data(), y.data(), z.data(), w.data(), {dx.data(), dy.data(), dz.data(), length.data()});
    for (std::size_t i = 0; i < count; ++i) {
      const float sum = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
      const float wanted = w[i] > 0.0F ? std::min(sum / w[i], 1.0F) : -1.0F;
      EXPECT_EQ(length[i], wanted) << i;
      EXPECT_EQ(dx[i], wanted >= kLeastLength ? x[i] / sum : 0.0F) << i;
      EXPECT_EQ(dy[i], wanted >= kLeastLength ? y[i] / sum : 0.0F) << i;
      EXPECT_EQ(dz[i], wanted >= kLeastLength ? z[i] / sum : 0.0F) << i;
    }
  }
}

VT_ON_EVERY_CPU_TARGET(NormalRows);

}  // namespace
}  // namespace vt::channels
