#include "store/texel/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace vt {
namespace {

// The definition: sign * mantissa * 2^exponent, in doubles.
double value_of_half(std::uint32_t half) {
  const double sign = (half & 0x8000) != 0 ? -1.0 : 1.0;
  const int exponent = static_cast<int>(half >> 10 & 31);
  const int mantissa = static_cast<int>(half & 1023);
  if (exponent == 31) return mantissa != 0 ? std::nan("") : sign * std::numeric_limits<double>::infinity();
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

// The definition of rounding: the nearest of all halves, of two the one with an even last bit.
std::uint16_t nearest_half(float value) {
  if (std::isinf(value)) return value > 0 ? 0x7C00 : 0xFC00;
  const double magnitude = std::abs(double{value});
  std::uint32_t low = 0;
  std::uint32_t high = 0x7C00;  // stands for 65536 here, where it would lie if exponents went on
  const auto magnitude_of = [](std::uint32_t half) { return half == 0x7C00 ? 65536.0 : value_of_half(half); };
  while (high - low > 1) {
    const std::uint32_t middle = (low + high) / 2;
    (magnitude_of(middle) <= magnitude ? low : high) = middle;
  }
  const double below = magnitude - magnitude_of(low);
  const double above = magnitude_of(high) - magnitude;
  const std::uint32_t nearest = below < above || (below == above && low % 2 == 0) ? low : high;
  return static_cast<std::uint16_t>(nearest | (std::signbit(value) ? 0x8000U : 0U));
}

static_assert(float_from_half(0x3C00) == 1.0F && half_from_float(1.0F) == 0x3C00);

TEST(Half, IsTheFloatThatItsBitsSay) {
  for (std::uint32_t half = 0; half < 65536; ++half) {
    const float value = float_from_half(static_cast<std::uint16_t>(half));
    const double wanted = value_of_half(half);
    ASSERT_TRUE(std::isnan(wanted) ? std::isnan(value) : value == wanted) << half;
    ASSERT_EQ(std::signbit(value), (half & 0x8000) != 0) << half;
  }
}

TEST(Half, ComesBackThroughItsFloat) {
  for (std::uint32_t half = 0; half < 65536; ++half) {
    const bool is_nan = (half & 0x7FFF) > 0x7C00;
    const std::uint32_t wanted = is_nan ? half | 0x0200 : half;  // quiet
    ASSERT_EQ(half_from_float(float_from_half(static_cast<std::uint16_t>(half))), wanted) << half;
  }
}

TEST(Half, IsTheNearestToAnyFloatAndEvenBetweenTwo) {
  const auto check = [](float value) { ASSERT_EQ(half_from_float(value), nearest_half(value)) << std::hexfloat << value; };
  // Every half, every middle between two, and the floats on both sides of each.
  for (std::uint32_t half = 0; half < 0x7C00; ++half) {
    const auto here = static_cast<float>(value_of_half(half));
    const double next = half == 0x7BFF ? 65536.0 : value_of_half(half + 1);
    const auto middle = static_cast<float>((double{here} + next) / 2.0);
    for (const float value : {here, middle})
      for (const float near : {value, std::nextafter(value, 1e9F), std::nextafter(value, -1e9F)}) {
        check(near);
        check(-near);
      }
  }
  std::mt19937 random(1);
  for (int i = 0; i < 1000000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isnan(value)) check(value);
  }
}

#if defined(__FLT16_MANT_DIG__)
TEST(Half, AgreesWithTheCompilersOwn) {
  for (std::uint32_t half = 0; half < 65536; ++half) {
    const auto own = static_cast<float>(std::bit_cast<_Float16>(static_cast<std::uint16_t>(half)));
    ASSERT_EQ(std::bit_cast<std::uint32_t>(float_from_half(static_cast<std::uint16_t>(half))), std::bit_cast<std::uint32_t>(own)) << half;
  }
  std::mt19937 random(2);
  for (int i = 0; i < 1000000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    ASSERT_EQ(half_from_float(value), std::bit_cast<std::uint16_t>(static_cast<_Float16>(value))) << std::hexfloat << value;
  }
}
#endif

TEST(Half, NoDataIsANumberOfNeither) { EXPECT_TRUE(std::isnan(float_from_half(kHalfNoData))); }

}  // namespace
}  // namespace vt
