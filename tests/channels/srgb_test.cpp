#include "builder/channels/srgb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace vt::channels {
namespace {

// The definition, slow and plain: the code whose position on the code axis is nearest.
int nearest_code(Transfer transfer, float light) {
  const long double clamped = std::clamp(static_cast<long double>(light), 0.0L, 1.0L);
  const long double position = transfer == Transfer::kLinear ? clamped
                               : clamped <= 0.0031308L       ? clamped * 12.92L
                                                             : 1.055L * std::pow(clamped, 1.0L / 2.4L) - 0.055L;
  return static_cast<int>(std::lround(position * 255.0L));
}

class CodeTables : public testing::TestWithParam<Transfer> {};

TEST_P(CodeTables, EveryCodeComesBack) {
  const CodeTable& table = code_table(GetParam());
  for (int code = 0; code < 256; ++code) EXPECT_EQ(table.code(table.light(static_cast<std::uint8_t>(code))), code);
}

TEST_P(CodeTables, GiveTheNearestCodeEverywhere) {
  const CodeTable& table = code_table(GetParam());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  int disagreements = 0;
  for (int i = 0; i < 400000; ++i) {
    // Dense near zero, where sRGB is steepest.
    const float light = i % 2 == 0 ? uniform(random) : uniform(random) * uniform(random) * 0.02F;
    const int found = table.code(light);
    const int wanted = nearest_code(GetParam(), light);
    if (found == wanted) continue;
    // The two differ only where the light lies on the border between two codes to within a float.
    EXPECT_EQ(std::abs(found - wanted), 1);
    const double border = linear_from_code(GetParam(), (std::max(found, wanted) - 0.5) / 255.0);
    EXPECT_NEAR(light, border, 1.2e-7 * border) << "codes " << found << " and " << wanted;
    ++disagreements;
  }
  EXPECT_LT(disagreements, 100);
}

TEST_P(CodeTables, NeverDecrease) {
  const CodeTable& table = code_table(GetParam());
  int last = 0;
  for (int i = 0; i <= 1 << 20; ++i) {
    const int code = table.code(static_cast<float>(i) / (1 << 20));
    ASSERT_GE(code, last);
    ASSERT_LE(code, last + 1);
    last = code;
  }
  EXPECT_EQ(last, 255);
}

TEST_P(CodeTables, ClampWhatIsNotLight) {
  const CodeTable& table = code_table(GetParam());
  EXPECT_EQ(table.code(-1e30F), 0);
  EXPECT_EQ(table.code(std::numeric_limits<float>::quiet_NaN()), 0);
  EXPECT_EQ(table.code(1e30F), 255);
  EXPECT_EQ(table.code(std::numeric_limits<float>::infinity()), 255);
}

INSTANTIATE_TEST_SUITE_P(Transfers, CodeTables, testing::Values(Transfer::kLinear, Transfer::kSrgb));

TEST(Srgb, IsItsOwnInverse) {
  for (int i = 0; i <= 1000; ++i) {
    const double code = i / 1000.0;
    // The published constants 0.04045 and 0.0031308 meet to about 1e-8 in light, 3e-7 in code.
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(code)), code, 5e-7);
  }
  EXPECT_NEAR(linear_from_srgb(188.0 / 255.0), 0.5, 0.003);  // half the light is code 188, not 128
}

}  // namespace
}  // namespace vt::channels
