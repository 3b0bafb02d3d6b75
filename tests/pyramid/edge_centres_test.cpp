#include "builder/pyramid/edge_centres.h"

#include <gtest/gtest.h>

#include <cmath>

#include "builder/channels/samples/wide_value.h"
#include "tests/pyramid/cascade_fixture.h"

namespace vt::pyramid {
namespace {

constexpr int kPlanes = 4;  // height, weight, and the bounds of the height
constexpr channels::CentreRange kAnything{-1e30, 1e30};

const test::PlaneRules& rules() {
  using channels::PlaneRule;
  static const test::PlaneRules made{{PlaneRule::kLinear, PlaneRule::kLinear, PlaneRule::kLeast, PlaneRule::kGreatest}, 1};
  return made;
}

template <class Height>
test::WholeImage heights_of(const LayerShape& layer, const Height& height) {
  test::WholeImage image(layer, 0, kPlanes);
  for (std::int64_t y = 0; y < image.data.height; ++y)
    for (std::int64_t x = 0; x < image.data.width; ++x) {
      const double value = height(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      const bool is_void = std::isnan(value);
      image.at(x, y, 0) = is_void ? 0.0F : static_cast<float>(value);
      image.at(x, y, 1) = is_void ? 0.0F : 1.0F;
      image.at(x, y, 2) = is_void ? rules().nothing(2) : static_cast<float>(value);
      image.at(x, y, 3) = is_void ? rules().nothing(3) : static_cast<float>(value);
    }
  return image;
}

Levels levels_with_centres(const test::WholeImage& base, const channels::CentreRange& range, int levels_at_once) {
  return levels_by_cascade(
      {.base = base, .kernel = box_kernel(), .rules = rules(), .centre_range = range, .levels_at_once = levels_at_once});
}

// A hyperbolic paraboloid is straight along rows and along columns: every texel has its height at the centre,
// also those whose centre lies outside the data, down to levels of two texels.
TEST(EdgeCentres, HeightsBelongToTheCentresOfTheirTexelsAtEverySizeAndLevel) {
  const auto height = [](double x, double y) { return 3.0 * x - 2.0 * y + 0.01 * x * y + 100.0; };
  for (const TexelRect data : {TexelRect{0, 0, 257, 65}, TexelRect{0, 0, 65, 257}, TexelRect{0, 0, 100, 37}, TexelRect{0, 0, 129, 128},
                               TexelRect{0, 0, 43, 1}, TexelRect{0, 0, 64, 64}})
    for (const int levels_at_once : {1, 3}) {
      const Levels levels = levels_with_centres(heights_of({.data = data}, height), kAnything, levels_at_once);
      for (std::size_t k = 1; k < levels.size(); ++k) {
        const test::WholeImage& level = levels[k];
        const double scale = std::exp2(static_cast<double>(k));
        for (std::int64_t y = 0; y < level.data.height; ++y)
          for (std::int64_t x = 0; x < level.data.width; ++x) {
            // One row or column alone says nothing of the slope across it: it stays in the middle of its
            // data.
            const auto centre = [&](std::int64_t i, std::int64_t count, std::int64_t finest) {
              return count == 1 ? static_cast<double>(finest) / 2.0 : (static_cast<double>(i) + 0.5) * scale;
            };
            const double wanted = height(centre(x, level.data.width, data.width), centre(y, level.data.height, data.height));
            // Floats of about 1000, added up and divided; lines through two of them may double the rounding
            // at each axis.
            ASSERT_NEAR(level.get(x, y, 0) / level.get(x, y, 1), wanted, 0.002)
                << data.width << " x " << data.height << ", level " << k << ": " << x << ", " << y;
          }
      }
    }
}

// What goes on is the mean all the same: the sum of heights is that of the finest level, and the coarsest
// texel is the mean of all.
TEST(EdgeCentres, CoarserLevelsAreMadeOfMeans) {
  const auto height = [](double x, double y) { return std::sin(x) * 50.0 + y; };
  const test::WholeImage base = heights_of({.data = {0, 0, 77, 51}}, height);
  double sum = 0.0;
  for (std::int64_t y = 0; y < 51; ++y)
    for (std::int64_t x = 0; x < 77; ++x) sum += static_cast<double>(base.get(x, y, 0));
  for (const int levels_at_once : {1, 2, 9}) {
    const Levels levels = levels_with_centres(base, kAnything, levels_at_once);
    const test::WholeImage& top = levels.back();
    EXPECT_NEAR(top.get(0, 0, 0) / top.get(0, 0, 1), sum / (77 * 51), 1e-4);
  }
}

// Bounds hold every height under them, the one that is stored, and all bounds under them.
TEST(EdgeCentres, BoundsHoldTheHeightsAtTheCentresToo) {
  const auto height = [](double x, double y) { return std::sin(x * 1.7) * 30.0 - 4.0 * x + std::cos(y) * 20.0; };
  const test::WholeImage base = heights_of({.data = {0, 0, 77, 51}}, height);
  bool is_outside_the_data = false;
  for (const int levels_at_once : {1, 2, 9}) {
    const Levels levels = levels_with_centres(base, kAnything, levels_at_once);
    const Levels means = levels_by_definition(base, box_kernel(), rules());
    for (std::size_t k = 1; k < levels.size(); ++k) {
      const test::WholeImage& level = levels[k];
      for (std::int64_t y = 0; y < level.data.height; ++y)
        for (std::int64_t x = 0; x < level.data.width; ++x) {
          const float here = level.get(x, y, 0) / level.get(x, y, 1);
          ASSERT_LE(level.get(x, y, 2), here);
          ASSERT_GE(level.get(x, y, 3), here);
          ASSERT_LE(level.get(x, y, 2), means[k].get(x, y, 2));
          ASSERT_GE(level.get(x, y, 3), means[k].get(x, y, 3));
          is_outside_the_data = is_outside_the_data || level.get(x, y, 2) < means[k].get(x, y, 2);
          if (k > 1) {
            for (std::int64_t v = 2 * y; v < std::min(2 * y + 2, levels[k - 1].data.height); ++v)
              for (std::int64_t u = 2 * x; u < std::min(2 * x + 2, levels[k - 1].data.width); ++u) {
                ASSERT_LE(level.get(x, y, 2), levels[k - 1].get(u, v, 2));
                ASSERT_GE(level.get(x, y, 3), levels[k - 1].get(u, v, 3));
              }
          }
        }
    }
  }
  EXPECT_TRUE(is_outside_the_data) << "a slope goes on past the edge";
}

// Heights that floats do not hold keep their precision at the centres, and bounds hold what is stored.
TEST(EdgeCentres, ValuesInTwoPlanesAreContinuedInDoublePrecision) {
  using channels::PlaneRule;
  static const test::PlaneRules wide{
      {PlaneRule::kLinear, PlaneRule::kRemainder, PlaneRule::kLinear, PlaneRule::kLeast, PlaneRule::kGreatest}, 2};
  constexpr double kOrigin = 2e9;
  const auto height = [](double x, double y) { return 2000000000.001 + 0.25 * x - 0.125 * y; };
  const LayerShape layer{.data = {0, 0, 77, 51}};
  test::WholeImage base(layer, 0, 5);
  for (std::int64_t y = 0; y < 51; ++y)
    for (std::int64_t x = 0; x < 77; ++x) {
      const double value = height(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      base.at(x, y, 0) = static_cast<float>(value);
      base.at(x, y, 1) = channels::remainder_of(value, base.at(x, y, 0));
      base.at(x, y, 2) = 1.0F;
      base.at(x, y, 3) = channels::float_below(value - kOrigin);
      base.at(x, y, 4) = channels::float_above(value - kOrigin);
    }
  const channels::CentreRange range{-1e30, 1e30, kOrigin};
  const Levels levels = levels_by_cascade({.base = base, .kernel = box_kernel(), .rules = wide, .centre_range = range});
  for (std::size_t k = 1; k + 1 < levels.size(); ++k) {
    const test::WholeImage& level = levels[k];
    if (level.data.width == 1 || level.data.height == 1) continue;
    const double scale = std::exp2(static_cast<double>(k));
    for (std::int64_t y = 0; y < level.data.height; ++y)
      for (std::int64_t x = 0; x < level.data.width; ++x) {
        const double stored = (static_cast<double>(level.get(x, y, 0)) + static_cast<double>(level.get(x, y, 1))) / level.get(x, y, 2);
        // Two floats hold 48 bits of 2^31; each level rounds once, and a line through two means may treble
        // that at each axis.
        ASSERT_NEAR(stored, height((static_cast<double>(x) + 0.5) * scale, (static_cast<double>(y) + 0.5) * scale),
                    9.0 * static_cast<double>(k + 1) * 0x1p-17)
            << "level " << k << ": " << x << ", " << y;
        ASSERT_LE(level.get(x, y, 3), stored - kOrigin);
        ASSERT_GE(level.get(x, y, 4), stored - kOrigin);
      }
  }
}

TEST(EdgeCentres, NothingIsContinuedFromVoidsNorPastWhatTheFormatHolds) {
  const auto ramp = [](double x, double) { return 10.0 * x; };
  // Column 5 of level 1 covers columns 10 and, half, nothing; column 4 is void.
  const auto holed = [&](double x, double y) { return x > 8.0 && x < 10.0 ? std::nan("") : ramp(x, y); };
  const Levels beside_a_void = levels_with_centres(heights_of({.data = {0, 0, 11, 4}}, holed), kAnything, 1);
  EXPECT_EQ(beside_a_void[1].get(5, 0, 0) / beside_a_void[1].get(5, 0, 1), 105.0F) << "the mean of what is there";
  const Levels limited = levels_with_centres(heights_of({.data = {0, 0, 11, 4}}, ramp), {0.0, 107.0}, 1);
  EXPECT_EQ(limited[1].get(5, 0, 0) / limited[1].get(5, 0, 1), 107.0F);
  const Levels free = levels_with_centres(heights_of({.data = {0, 0, 11, 4}}, ramp), kAnything, 1);
  EXPECT_EQ(free[1].get(5, 0, 0) / free[1].get(5, 0, 1), 110.0F);
}

// No edge cuts a column of a closed layer: the last one goes on at the other side, whose mean with this one
// belongs to its centre.
TEST(EdgeCentres, OfAClosedLayerOnlyRowsAreContinued) {
  const auto height = [](double x, double y) { return 10.0 * std::cos(x * std::acos(-1.0) / 45.0) + y; };
  const test::WholeImage base = heights_of({.data = {0, 0, 45, 7}, .is_closed = true}, height);
  const Levels levels = levels_with_centres(base, kAnything, 2);
  for (std::int64_t y = 0; y < 4; ++y) {
    const double mean = (height(44.5, 0.0) + height(0.5, 0.0)) / 2.0;
    EXPECT_NEAR(levels[1].get(22, y, 0) / levels[1].get(22, y, 1), mean + 2.0 * static_cast<double>(y) + 1.0, 1e-4);
  }
}

}  // namespace
}  // namespace vt::pyramid
