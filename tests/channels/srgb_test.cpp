#include "builder/channels/shared/srgb.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

namespace vt::channels {
namespace {

// Light of a code, in more digits than the tables have.
long double light_of(Transfer transfer, int code) {
  const long double c = static_cast<long double>(code) / 255.0L;
  if (transfer == Transfer::kLinear) return c;
  return c <= 0.04045L ? c / 12.92L : std::pow((c + 0.055L) / 1.055L, 2.4L);
}

// The definition, slow and plain: the code whose light is nearest.
int nearest_code(Transfer transfer, float light) {
  int best = 0;
  for (int code = 1; code < 256; ++code)
    if (std::abs(light_of(transfer, code) - static_cast<long double>(light)) <
        std::abs(light_of(transfer, best) - static_cast<long double>(light)))
      best = code;
  return best;
}

class CodeTables : public testing::TestWithParam<Transfer> {};

TEST_P(CodeTables, EveryCodeComesBack) {
  const CodeTable& table = code_table(GetParam());
  for (int code = 0; code < 256; ++code) EXPECT_EQ(table.code(table.light(static_cast<std::uint8_t>(code)), code / 3), code);
}

TEST_P(CodeTables, GiveTheCodeOfTheNearestLightEverywhere) {
  const CodeTable& table = code_table(GetParam());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  int disagreements = 0;
  for (int i = 0; i < 100000; ++i) {
    // Dense near zero, where sRGB is steepest.
    const float light = i % 2 == 0 ? uniform(random) : uniform(random) * uniform(random) * 0.02F;
    const int found = table.code(light, i / 2);
    const int wanted = nearest_code(GetParam(), light);
    if (found == wanted) continue;
    // The two differ only where the light lies half way between two codes to within a float.
    EXPECT_EQ(std::abs(found - wanted), 1);
    const auto border = static_cast<double>(0.5L * (light_of(GetParam(), found) + light_of(GetParam(), wanted)));
    EXPECT_NEAR(light, border, 1.2e-7 * border) << "codes " << found << " and " << wanted;
    ++disagreements;
  }
  EXPECT_LT(disagreements, 25);
}

TEST_P(CodeTables, OfTwoCodesJustAsNearEvenColumnsTakeTheUpperAndOddOnesTheLower) {
  const CodeTable& table = code_table(GetParam());
  for (int code = 0; code < 255; ++code) {
    const float lower = table.light(static_cast<std::uint8_t>(code));
    const float upper = table.light(static_cast<std::uint8_t>(code + 1));
    // As means of two and of four texels come out of a filter.
    for (const float middle : {0.5F * (lower + upper), 0.5F * (0.5F * (lower + upper) + 0.5F * (upper + lower))})
      for (const std::int64_t column : {0, 1, 6, 7}) EXPECT_EQ(table.code(middle, column), column % 2 == 0 ? code + 1 : code);
    // Two floats on either side count as half way, because means of four are rounded three times; a few more
    // do not.
    const auto beside = [&](int floats) { return std::bit_cast<float>(std::bit_cast<std::int32_t>(0.5F * (lower + upper)) + floats); };
    for (const int floats : {-2, -1, 1}) {
      EXPECT_EQ(table.code(beside(floats), 0), code + 1);
      EXPECT_EQ(table.code(beside(floats), 1), code);
    }
    for (const std::int64_t column : {0, 1}) {
      EXPECT_EQ(table.code(beside(-3), column), code);
      EXPECT_EQ(table.code(beside(2), column), code + 1);
    }
  }
}

// What rounding the means of four random codes does to the mean of all light, where codes are proportional to
// light (below 11) and over all of them: rounding on the code axis, or all ties up, brightens by percents in
// the dark. A step there is up to the light itself, of which 2^20 roundings leave 0.03 % by chance.
TEST(Srgb, RoundedMeansKeepTheMeanLight) {
  const CodeTable& table = code_table(Transfer::kSrgb);
  std::mt19937 random(3);
  for (const unsigned codes : {3U, 6U, 10U, 256U}) {
    double wanted = 0.0;
    double is = 0.0;
    for (int i = 0; i < 1 << 20; ++i) {
      float sum = 0.0F;
      for (int k = 0; k < 4; ++k) sum += table.light(static_cast<std::uint8_t>(random() % codes));
      const float mean = 0.25F * sum;
      wanted += static_cast<double>(mean);
      is += static_cast<double>(table.light(table.code(mean, i)));
    }
    EXPECT_NEAR(is / wanted, 1.0, 0.001) << "codes below " << codes;
  }
}

TEST_P(CodeTables, NeverDecrease) {
  const CodeTable& table = code_table(GetParam());
  int last = 0;
  for (int i = 0; i <= 1 << 20; ++i) {
    const int code = table.code(static_cast<float>(i) / (1 << 20), 0);
    ASSERT_GE(code, last);
    ASSERT_LE(code, last + 1);
    last = code;
  }
  EXPECT_EQ(last, 255);
}

TEST_P(CodeTables, ClampWhatIsNotLight) {
  const CodeTable& table = code_table(GetParam());
  EXPECT_EQ(table.code(-1e30F, 1), 0);
  EXPECT_EQ(table.code(std::numeric_limits<float>::quiet_NaN(), 0), 0);
  EXPECT_EQ(table.code(1e30F, 1), 255);
  EXPECT_EQ(table.code(std::numeric_limits<float>::infinity(), 1), 255);
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
