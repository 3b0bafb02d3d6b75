#include "builder/resample/grid/rect_index.h"

#include <gtest/gtest.h>

#include <random>

namespace vt::resample {
namespace {

TexelRect random_rect(std::mt19937& random, std::int64_t extent, std::int64_t largest) {
  const auto number = [&](std::int64_t limit) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(limit)); };
  return {number(extent) - extent / 4, number(extent) - extent / 4, number(largest), number(largest)};
}

TEST(RectIndex, FindsWhatAskingEveryRectangleFinds) {
  std::mt19937 random(7);
  for (const std::size_t count : {0U, 1U, 2U, 7U, 8U, 9U, 64U, 65U, 1000U}) {
    std::vector<TexelRect> rects;
    for (std::size_t i = 0; i < count; ++i) rects.push_back(random_rect(random, 1000, i % 10 == 0 ? 900 : 40));
    const RectIndex index(rects);
    std::vector<std::uint32_t> found;
    for (int i = 0; i < 300; ++i) {
      const TexelRect query = random_rect(random, 1200, i % 3 == 0 ? 1 : 200);
      std::vector<std::uint32_t> expected;
      for (std::size_t r = 0; r < count; ++r)
        if (!intersect(rects[r], query).empty()) expected.push_back(static_cast<std::uint32_t>(r));
      index.find(query, found);
      EXPECT_EQ(found, expected);
      EXPECT_EQ(index.touches(query), !expected.empty());
    }
  }
}

TEST(RectIndex, WorksAtTheSizeOfTheEarth) {
  // 80 million texels around the equator at half a metre; sums of coordinates must not overflow 32 bits.
  const std::vector<TexelRect> rects{{79'999'000, 39'999'000, 1000, 1000}, {0, 0, 1, 1}};
  const RectIndex index(rects);
  EXPECT_TRUE(index.touches({79'999'999, 39'999'999, 1, 1}));
  EXPECT_TRUE(index.touches({0, 0, 80'000'000, 40'000'000}));
  EXPECT_FALSE(index.touches({1, 1, 79'998'999, 39'998'999}));
}

TEST(Covers, EqualsAskingEveryTexel) {
  std::mt19937 random(11);
  int covered = 0;
  for (int round = 0; round < 2000; ++round) {
    const TexelRect whole{3, 2, 9, 7};
    std::vector<TexelRect> parts;
    for (std::size_t i = 0; i < 1 + random() % 12; ++i) parts.push_back(random_rect(random, 16, 14));
    bool all = true;
    for (std::int64_t y = whole.y; y < whole.bottom(); ++y)
      for (std::int64_t x = whole.x; x < whole.right(); ++x) {
        bool any = false;
        for (const TexelRect& part : parts) any = any || (!part.empty() && part.contains(x, y));
        all = all && any;
      }
    EXPECT_EQ(covers(parts, whole), all);
    covered += all ? 1 : 0;
  }
  EXPECT_GT(covered, 20) << "both answers have to occur";
}

}  // namespace
}  // namespace vt::resample
