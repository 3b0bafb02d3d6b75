#include "builder/pyramid/plane_cascade.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/pyramid/cascade_fixture.h"

namespace vt::pyramid {
namespace {

using channels::PlaneRule;

constexpr int kCascadePlanes = 5;  // two values, the weight, and the least and the greatest of the first value
constexpr int kCascadeWeight = 2;
constexpr std::size_t kHigh = 0, kLow = 1;  // of a value in two planes

const test::PlaneRules& cascade_rules() {
  static const test::PlaneRules made{{PlaneRule::kLinear, PlaneRule::kLinear, PlaneRule::kLinear, PlaneRule::kLeast, PlaneRule::kGreatest},
                                     kCascadeWeight};
  return made;
}

enum class Content { kOpaque, kHoles, kTranslucent };

test::WholeImage make_image(const LayerShape& layer, Content content) {
  test::WholeImage image(layer, 0, kCascadePlanes);
  const TexelRect& data = layer.data;
  std::mt19937 random(static_cast<unsigned>(data.width * 31 + data.height));
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  for (std::int64_t y = data.y; y < data.bottom(); ++y)
    for (std::int64_t x = data.x; x < data.right(); ++x) {
      float weight = 1.0F;
      if (content == Content::kHoles && (((x / 9) % 5 == 1 && (y / 7) % 4 == 2) || uniform(random) < 0.05F)) weight = 0.0F;
      if (content == Content::kTranslucent) weight = uniform(random);
      for (int p = 0; p < kCascadeWeight; ++p) image.at(x, y, p) = weight * uniform(random);
      image.at(x, y, kCascadeWeight) = weight;
      for (const int p : {3, 4}) image.at(x, y, p) = weight > 0.0F ? image.at(x, y, 0) : cascade_rules().nothing(p);
    }
  return image;
}

std::vector<HalvingKernel> every_kernel() {
  std::vector<HalvingKernel> kernels(all_kernels().begin(), all_kernels().end());
  for (const HalvingKernel& kernel : all_kernels())
    if (kernel.has_negative_lobes()) {
      kernels.push_back(kernel);
      kernels.back().limits_ringing = true;
    }
  return kernels;
}

// Widths of closed layers that can be halved often, once and never; of the last, blocks of fractional levels
// lie at the seam.
std::vector<LayerShape> every_shape() {
  return {{.data = {0, 0, 101, 53}},
          {.data = {0, 0, 1, 39}},
          {.data = {37, 51, 80, 47}},
          {.data = {0, 0, 96, 20}, .is_closed = true},
          {.data = {0, 0, 90, 21}, .is_closed = true},
          {.data = {0, 0, 165, 9}, .is_closed = true},
          {.data = {0, 0, 13, 13}, .is_closed = true},
          {.data = {0, 0, 3, 4}, .is_closed = true},
          {.data = {0, 0, 1, 5}, .is_closed = true}};
}

// Each level of blocks in tiers of one, two and all levels, whose only tie is carry, and the neighbours that
// blocks show of their texels.
TEST(PlaneCascade, BlocksEqualTheWholeImageBitForBit) {
  for (const HalvingKernel& kernel : every_kernel())
    for (const Content content : {Content::kOpaque, Content::kHoles, Content::kTranslucent})
      for (const LayerShape& layer : every_shape()) {
        const test::WholeImage base = make_image(layer, content);
        const Levels truth = levels_by_definition(base, kernel, cascade_rules());
        for (const int levels_at_once : {1, 2, 9}) {
          const Levels result = levels_by_cascade(
              {.base = base, .kernel = kernel, .rules = cascade_rules(), .levels_at_once = levels_at_once, .truth = &truth});
          for (std::size_t k = 0; k < truth.size(); ++k)
            ASSERT_EQ(result[k].floats, truth[k].floats)
                << kernel.name << (kernel.limits_ringing ? " limited, " : ", ") << layer.data.width << " x " << layer.data.height
                << (layer.is_closed ? " closed, " : ", ") << levels_at_once << " levels at once, level " << k;
        }
      }
}

// A value in two planes is the double-precision mean at every level: 9 levels of heights about 2^31 and about
// 10^6 with a relief of millimetres, holes among them, against sums in long double over all finest texels.
TEST(PlaneCascade, APlaneAndItsRemainderAreTheMeanInDoublePrecision) {
  const test::PlaneRules pair{{PlaneRule::kLinear, PlaneRule::kRemainder, PlaneRule::kLinear}, kCascadeWeight};
  constexpr std::int64_t kEdge = 512;
  for (const double base : {2147483000.0, 1e6, -0.1}) {
    std::vector<double> heights(kEdge * kEdge);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> relief(0.0, 0.002 * std::max(1.0, base / 1e6));
    test::WholeImage level({0, 0, kEdge, kEdge}, 3);
    for (std::int64_t y = 0; y < kEdge; ++y)
      for (std::int64_t x = 0; x < kEdge; ++x) {
        const bool is_hole = (x / 5 + y / 3) % 11 == 4;
        double& height = heights[static_cast<std::size_t>(y * kEdge + x)];
        height = is_hole ? std::nan("") : base + relief(random);
        if (is_hole) continue;
        level.at(x, y, kHigh) = static_cast<float>(height);
        level.at(x, y, kLow) = static_cast<float>(height - static_cast<double>(static_cast<float>(height)));
        level.at(x, y, kCascadeWeight) = 1.0F;
      }
    for (int k = 1; k <= 9; ++k) {
      level = test::halve_whole(level, box_kernel(), pair);
      const std::int64_t step = std::int64_t{1} << k;
      for (std::int64_t y = 0; y < level.data.height; ++y)
        for (std::int64_t x = 0; x < level.data.width; ++x) {
          long double sum = 0.0L;
          std::int64_t count = 0;
          for (std::int64_t fy = y * step; fy < (y + 1) * step; ++fy)
            for (std::int64_t fx = x * step; fx < (x + 1) * step; ++fx)
              if (const double height = heights[static_cast<std::size_t>(fy * kEdge + fx)]; !std::isnan(height)) {
                sum += static_cast<long double>(height);
                ++count;
              }
          if (count == 0) continue;
          const double value = (static_cast<double>(level.get(x, y, kHigh)) + static_cast<double>(level.get(x, y, kLow))) /
                               static_cast<double>(level.get(x, y, kCascadeWeight));
          // Two floats hold 48 bits; each level rounds the lower one once.
          ASSERT_NEAR(value, static_cast<double>(sum / static_cast<long double>(count)), 9 * std::abs(base) * 0x1p-48)
              << base << ", level " << k;
        }
    }
  }
}

TEST(PlaneCascade, RemaindersOfBlocksEqualThoseOfTheWholeImageBitForBit) {
  const test::PlaneRules pair{{PlaneRule::kLinear, PlaneRule::kRemainder, PlaneRule::kLinear}, kCascadeWeight};
  for (const char* name : {"box", "point"})
    for (const LayerShape& layer : every_shape()) {
      const HalvingKernel kernel = *kernel_from_name(name);
      test::WholeImage base(layer, 0, 3);
      std::mt19937 random(6);
      std::uniform_real_distribution<double> height(8000.0, 8001.0);
      for (std::int64_t y = base.data.y; y < base.data.bottom(); ++y)
        for (std::int64_t x = base.data.x; x < base.data.right(); ++x) {
          if (random() % 9 == 0) continue;
          const double value = height(random);
          base.at(x, y, kHigh) = static_cast<float>(value);
          base.at(x, y, kLow) = static_cast<float>(value - static_cast<double>(static_cast<float>(value)));
          base.at(x, y, kCascadeWeight) = 1.0F;
        }
      const Levels truth = levels_by_definition(base, kernel, pair);
      for (const int levels_at_once : {1, 2, 9}) {
        const Levels result =
            levels_by_cascade({.base = base, .kernel = kernel, .rules = pair, .levels_at_once = levels_at_once, .truth = &truth});
        for (std::size_t k = 0; k < truth.size(); ++k)
          ASSERT_EQ(result[k].floats, truth[k].floats) << name << " " << layer.data.width << " x " << layer.data.height
                                                       << (layer.is_closed ? " closed, " : ", ") << levels_at_once << ", level " << k;
      }
    }
}

TEST(PlaneCascade, BytesThatAreNoCarryAreRefused) {
  const TexelRect data{0, 0, 32, 32};
  PlaneCascade cascade(plan_block(data, data, 1, false, box_kernel()), {.data = data}, 1, {cascade_rules().rules, kCascadeWeight},
                       box_kernel(), 5);
  Levels levels{test::WholeImage(data, kCascadePlanes)};
  Collector collector(levels, nullptr, cascade_rules());
  collector.begin_block(cascade);
  const std::vector<std::vector<std::byte>> carry{std::vector<std::byte>(17)};
  const std::vector<std::int64_t> columns{0};
  const auto fed = cascade.feed_carry({.row = 0, .columns = columns, .tiles = carry}, collector);
  ASSERT_FALSE(fed.has_value());
  EXPECT_EQ(fed.error().code, ErrorCode::kCorrupt);
}

TEST(PlaneCascade, AConstantStaysConstantAndAHoleStaysAHole) {
  for (const HalvingKernel& kernel : {box_kernel(), kaiser3_kernel()}) {
    test::WholeImage level({0, 0, 300, 200}, kCascadePlanes);
    for (std::int64_t y = 0; y < 200; ++y)
      for (std::int64_t x = 0; x < 300; ++x) {
        const bool is_hole = x >= 100 && x < 164 && y >= 60 && y < 124;
        level.at(x, y, 0) = is_hole ? 0.0F : 0.25F;
        level.at(x, y, kCascadeWeight) = is_hole ? 0.0F : 1.0F;
      }
    for (int k = 1; k <= 3; ++k) {
      level = test::halve_whole(level, kernel, cascade_rules());
      for (std::int64_t y = 0; y < level.data.height; ++y)
        for (std::int64_t x = 0; x < level.data.width; ++x) {
          const float weight = level.get(x, y, kCascadeWeight);
          ASSERT_GE(weight, 0.0F);
          ASSERT_LE(weight, 1.0F);
          const std::int64_t fine_x = x << k;
          const std::int64_t fine_y = y << k;
          const std::int64_t size = std::int64_t{1} << k;
          const bool under_hole = fine_x >= 100 && fine_x + size <= 164 && fine_y >= 60 && fine_y + size <= 124;
          if (under_hole) {
            ASSERT_EQ(weight, 0.0F) << "data grew into the hole at level " << k;
          }
          // Float rounding of two passes over at most 12 taps a level.
          if (weight > 0.0F) {
            ASSERT_NEAR(level.get(x, y, 0) / weight, 0.25F, 1e-5F) << "the hole leaked at level " << k;
          }
        }
    }
  }
}

}  // namespace
}  // namespace vt::pyramid
