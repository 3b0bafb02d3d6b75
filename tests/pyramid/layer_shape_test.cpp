#include "builder/pyramid/layer_shape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vt::pyramid {
namespace {

TEST(LayerShape, WrapsAsLongAsTheWidthCanBeHalved) {
  const LayerShape closed{.data = {0, 0, 360, 180}, .is_closed = true};
  for (int depth = 0; depth <= 9; ++depth) EXPECT_EQ(closed.wraps_at(depth), depth <= 3) << "360 is 8 times 45";
  const LayerShape open{.data = {0, 0, 360, 180}};
  EXPECT_FALSE(open.wraps_at(0));
}

// The columns of a level lie on a circle. One past the edge has its centre between those of the two that it
// is taken from, as far from each as the shares say.
TEST(LayerShape, ColumnsPastTheEdgeLieWhereTheirSharesSay) {
  for (const std::int64_t width : {360, 45, 7, 3, 1, 1 << 20, 43201})
    for (int depth = 0; depth <= 7; ++depth) {
      const LayerShape layer{.data = {0, 0, width, 4}, .is_closed = true};
      const std::int64_t columns = layer.data_at(depth).width;
      const double period = static_cast<double>(width) / std::exp2(depth);
      for (std::int64_t i = 1; i <= 12; ++i)
        for (const std::int64_t column : {-i, columns - 1 + i}) {
          const SeamColumn seen = layer.column_past_edge(depth, column);
          ASSERT_TRUE(seen.first >= 0 && seen.first < columns && seen.second >= 0 && seen.second < columns);
          ASSERT_TRUE(seen.share >= 0.0F && seen.share < 1.0F);
          ASSERT_EQ((1.0F - seen.share) + seen.share, 1.0F);
          if (columns == 1) continue;  // wherever it lies, there is but one
          double second = static_cast<double>(seen.second);
          if (second < static_cast<double>(seen.first)) second += period;  // once around
          const double place = static_cast<double>(seen.first) + seen.share * (second - static_cast<double>(seen.first));
          const double turns = (place - static_cast<double>(column)) / period;
          ASSERT_NEAR(turns, std::round(turns), 1e-5) << width << " columns, " << depth << " levels up, column " << column;
          if (layer.wraps_at(depth)) {
            ASSERT_EQ(seen.share, 0.0F);
          }
          if (seen.share > 0.0F) {
            ASSERT_LE(second - static_cast<double>(seen.first), 1.0) << "neighbours";
          }
        }
    }
}

TEST(LayerShape, FilledPartsOfTheLastColumnAndRow) {
  const LayerShape layer{.data = {0, 0, 257, 192}};
  EXPECT_EQ(layer.filled_column(0), 1.0);
  EXPECT_EQ(layer.filled_column(1), 0.5);
  EXPECT_EQ(layer.filled_column(4), 1.0 / 16);
  EXPECT_EQ(layer.filled_row(6), 1.0);
  EXPECT_EQ(layer.filled_row(7), 0.5);
  EXPECT_EQ((LayerShape{.data = {0, 0, 257, 192}, .is_closed = true}.filled_column(3)), 1.0) << "it goes on at the other side";
}

TEST(LayerShape, WrappedPartsAreTheColumnsOneByOne) {
  const TexelRect data{0, 10, 7, 30};
  for (std::int64_t x = -20; x < 20; ++x)
    for (std::int64_t width = 1; width < 30; ++width) {
      const TexelRect rect{x, 12, width, 5};
      std::int64_t next = 0;
      for (const WrappedPart& part : wrapped_parts(rect, data)) {
        ASSERT_EQ(part.offset, next);
        ASSERT_EQ(intersect(part.rect, data), part.rect);
        ASSERT_EQ(part.rect.y, 12);
        ASSERT_EQ(part.rect.height, 5);
        ASSERT_EQ(((x + part.offset - part.rect.x) % 7), 0);
        next += part.rect.width;
      }
      ASSERT_EQ(next, width);
    }
  EXPECT_EQ(wrapped_parts({2, 10, 3, 4}, data).size(), 1U);
}

}  // namespace
}  // namespace vt::pyramid
