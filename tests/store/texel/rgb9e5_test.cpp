#include "store/texel/rgb9e5.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace vt::store {
namespace {

// The extension's formulas in doubles, with the library's logarithm and powers.
std::uint32_t packed_by_definition(double r, double g, double b) {
  const auto clamped = [](double v) { return std::isnan(v) ? 0.0 : std::clamp(v, 0.0, 65408.0); };
  const double rc = clamped(r), gc = clamped(g), bc = clamped(b);
  const double brightest = std::max({rc, gc, bc});
  const double preliminary = std::max(-16.0, brightest > 0 ? std::floor(std::log2(brightest)) : -16.0) + 1 + 15;
  const double largest = std::floor(brightest / std::exp2(preliminary - 15 - 9) + 0.5);
  const double exponent = largest < 512 ? preliminary : preliminary + 1;
  const auto mantissa = [&](double v) { return static_cast<std::uint32_t>(std::floor(v / std::exp2(exponent - 15 - 9) + 0.5)); };
  return mantissa(rc) | mantissa(gc) << 9U | mantissa(bc) << 18U | static_cast<std::uint32_t>(exponent) << 27U;
}

TEST(Rgb9e5, EveryCanonicalCodeComesBack) {
  // All exponents and all pairs of mantissas in each pair of channels, the third channel anywhere not above
  // the brighter. Canonical: the brightest mantissa uses its highest bit, or the exponent is 0.
  std::mt19937 random(1);
  for (std::uint32_t exponent = 0; exponent < 32; ++exponent) {
    for (std::uint32_t p = 0; p < 512; ++p) {
      for (std::uint32_t q = 0; q < 512; ++q) {
        const std::uint32_t brightest = std::max(p, q);
        const std::uint32_t other = static_cast<std::uint32_t>(random()) % (brightest + 1);
        for (const std::uint32_t mantissas : {p | q << 9U | other << 18U, other | p << 9U | q << 18U, q | other << 9U | p << 18U}) {
          const std::uint32_t code = mantissas | exponent << 27U;
          const auto [r, g, b] = unpack_rgb9e5(code);
          ASSERT_EQ(r, std::ldexp(static_cast<float>(mantissas & 511U), static_cast<int>(exponent) - 24));
          ASSERT_EQ(g, std::ldexp(static_cast<float>(mantissas >> 9U & 511U), static_cast<int>(exponent) - 24));
          ASSERT_EQ(b, std::ldexp(static_cast<float>(mantissas >> 18U), static_cast<int>(exponent) - 24));
          const std::uint32_t again = pack_rgb9e5(r, g, b);
          if (brightest >= 256 || exponent == 0) {
            ASSERT_EQ(again, code);
          } else {
            ASSERT_EQ(unpack_rgb9e5(again), unpack_rgb9e5(code)) << std::hex << code;
          }
        }
      }
    }
  }
}

TEST(Rgb9e5, RandomFloatsAsTheDefinitionInDoubles) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000000; ++i) {
    // Any bits at all, or three numbers of like size, or numbers a few units of the last place from where
    // rounding turns.
    std::array<float, 3> color{};
    for (float& value : color) value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (i % 3 == 1) {
      const int exponent = static_cast<int>(random() % 40) - 28;
      for (float& value : color) value = std::ldexp(static_cast<float>(random()), exponent - 32);
    }
    if (i % 3 == 2) {
      const int exponent = static_cast<int>(random() % 36) - 28;
      for (float& value : color) {
        const float turn = std::ldexp(static_cast<float>(random() % 1024) + 0.5F, exponent);
        value = std::bit_cast<float>(std::bit_cast<std::uint32_t>(turn) + static_cast<std::uint32_t>(random() % 5) - 2U);
      }
    }
    const auto [r, g, b] = color;
    ASSERT_EQ(pack_rgb9e5(r, g, b), packed_by_definition(r, g, b)) << r << " " << g << " " << b;
  }
}

TEST(Rgb9e5, ErrorIsHalfAStepOfTheBrightestChannelAtMost) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> log2(-14.0F, 15.9F);
  for (int i = 0; i < 1000000; ++i) {
    const std::array<float, 3> color{std::exp2(log2(random)), std::exp2(log2(random)), std::exp2(log2(random))};
    const std::array<float, 3> back = unpack_rgb9e5(pack_rgb9e5(color[0], color[1], color[2]));
    // The brightest mantissa is at least 256, so half a step is at most 1/512 of the brightest channel.
    const float brightest = std::max({color[0], color[1], color[2]});
    for (std::size_t c = 0; c < 3; ++c) ASSERT_LE(std::abs(back[c] - color[c]), brightest / 512.0F);
  }
}

TEST(Rgb9e5, HostileNumbers) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(pack_rgb9e5(0, 0, 0), 0U);
  EXPECT_EQ(pack_rgb9e5(-0.0F, kNan, -kInfinity), 0U);
  EXPECT_EQ(pack_rgb9e5(std::numeric_limits<float>::denorm_min(), 1e-40F, std::numeric_limits<float>::min()), 0U);
  EXPECT_EQ(pack_rgb9e5(kNan, 1.0F, -1.0F), pack_rgb9e5(0.0F, 1.0F, 0.0F));
  EXPECT_EQ(pack_rgb9e5(kInfinity, 1e30F, 65408.0F), 0xFFFFFFFFU);
  EXPECT_EQ(unpack_rgb9e5(0xFFFFFFFFU), (std::array<float, 3>{65408.0F, 65408.0F, 65408.0F}));
  EXPECT_EQ(unpack_rgb9e5(pack_rgb9e5(1.0F, 1.0F, 1.0F)), (std::array<float, 3>{1.0F, 1.0F, 1.0F}));
}

}  // namespace
}  // namespace vt::store
