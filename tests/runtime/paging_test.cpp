#include "runtime/paging.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/runtime/test_store.h"
#include "tests/support/paper_equations.h"

namespace vt::runtime {
namespace {

// --- The paper's equations -----------------------------------------------------------------------------------------------------------

TEST(Equations, LowerLeftCornerIsTheSameFromDimensionsAndExponents) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> anywhere(-0.5, 1.5);
  for (int vt = 10; vt <= 31; ++vt)
    for (int tile = 3; tile <= vt && tile <= 13; ++tile)
      for (int level = 0; level <= vt - tile; ++level) {
        const double center = anywhere(random);
        ASSERT_EQ(lower_left_from_dimensions(center, std::ldexp(1.0, tile), level, std::ldexp(1.0, vt)),
                  lower_left_from_exponents(center, tile, level, vt))
            << "vt " << vt << " tile " << tile << " level " << level;
      }
}

TEST(Equations, SolvingTheTwoKnownPairsGivesEquationFiveBitForBit) {
  std::mt19937_64 random(2);
  for (int vt = 10; vt <= 31; ++vt)
    for (int tile = 3; tile <= vt && tile <= 13; ++tile)
      for (int level = 0; level <= vt - tile; ++level) {
        // A center on the texel grid, as every paging center is.
        const double center = std::ldexp(static_cast<double>(random() >> (64 - vt)), -vt);
        const Linear pairs = transform_from_pairs(center, lower_left_from_exponents(center, tile, level, vt));
        const Linear five = transform_from_exponents(center, tile, level, vt);
        ASSERT_EQ(pairs.scale, five.scale);
        ASSERT_EQ(pairs.trans, five.trans);
      }
}

TEST(Equations, CenterMapsToOneHalfAndCornerToZero) {
  for (int vt = 10; vt <= 31; ++vt) {
    const double center = 0.3125;
    const Linear t = transform_from_exponents(center, 9, 1, vt);
    EXPECT_EQ(t(center), 0.5);
    EXPECT_EQ(t(lower_left_from_exponents(center, 9, 1, vt)), 0.0);
  }
}

TEST(Equations, EquationSevenIsTheConstantTermAndIsExactInFloatOnTheGrid) {
  // The clamped center is what makes it exact: 2^(vt-level-tile) * center then has at most as many bits as
  // the grid.
  for (int level = 0; level <= 12; ++level) {
    const int vt = 21;
    const int tile = 9;
    const double center = std::ldexp(5.0, -(vt - level - tile));
    const double trans = transform_from_exponents(center, tile, level, vt).trans;
    EXPECT_EQ(trans, 0.5 - 5.0);
    EXPECT_EQ(static_cast<double>(static_cast<float>(trans)), trans);
  }
}

TEST(Equations, LocalFormAgreesWithEquationFive) {
  const double center = 0.40625;
  const double origin = 0.40234375;
  const Linear global = transform_from_exponents(center, 9, 2, 20);
  const Linear local = local_transform(center, 9, 2, 20, origin);
  for (double d = -0.001; d <= 0.001; d += 0.0001) EXPECT_NEAR(local(d), global(origin + d), 1e-12);
}

TEST(Equations, ExtentOfALevelIsTheUnionOfItsTiles) {
  LayerInfo layer = test::layer_info({.tile_exponent = 8, .finest = 8, .data = {}, .paint = {}, .skip = {}}, {});
  for (int n = 1; n <= 8; ++n) {
    const auto layout = make_layout(layer, {.tile_exponent = 8, .tiles_per_side = n, .overrides = {}});
    ASSERT_TRUE(layout.has_value());
    for (const LevelLayout& level : layout->levels) {
      const TexelOrigin origin = box_origin(*layout, level, 0.37, 0.61);
      const Box whole = box_at(*layout, level.level, origin, level.box_texels());
      Box tiles = box_at(*layout, level.level, origin, level.tile_texels());
      for (int j = 0; j < level.tiles_per_side; ++j)
        for (int i = 0; i < level.tiles_per_side; ++i)
          tiles = union_of(tiles, box_at(*layout, level.level, {origin.x + i * level.tile_texels(), origin.y + j * level.tile_texels()},
                                         level.tile_texels()));
      EXPECT_EQ(tiles, whole);
      // Equation 6 with the level's own width.
      const int paper = paper_level(level.level, layer.finest);
      const Interval s =
          extent_around((whole.s_min + whole.s_max) / 2, static_cast<double>(level.box_texels()), paper, std::ldexp(1.0, 16));
      const Interval t =
          extent_around((whole.t_min + whole.t_max) / 2, static_cast<double>(level.box_texels()), paper, std::ldexp(1.0, 16));
      EXPECT_EQ((Box{s.min, t.min, s.max, t.max}), whole);
    }
  }
}

// --- Precision -----------------------------------------------------------------------------------------------------------------------

struct Case {
  Area area;
  LayerInfo layer;
};

Case random_case(std::mt19937_64& random, int vt) {
  Case c;
  c.area = {.west = -10.3, .south = 41.7, .east = 13.9, .north = 63.1};
  const int tile_exponent = 8;
  const std::int64_t width = std::int64_t{1} << vt;
  test::LayerSpec spec{.tile_exponent = tile_exponent, .finest = vt - tile_exponent, .data = {}, .paint = {}, .skip = {}};
  spec.data = {static_cast<std::int64_t>(random() % 100), static_cast<std::int64_t>(random() % 100), width - 217, width * 3 / 4 - 31};
  c.layer = test::layer_info(spec, c.area);
  return c;
}

// Where (u, v) lies in a tile, from the definitions alone, in long double. V counts from the northern row.
std::pair<long double, long double> exact_uv(const Case& c, Level level, TexelOrigin tile, long double tile_texels, long double u,
                                             long double v) {
  const long double scale = std::ldexp(1.0L, level.value - c.layer.finest.value);
  const long double x = c.area.west + u * (static_cast<long double>(c.area.east) - c.area.west);
  const long double y = c.area.south + v * (static_cast<long double>(c.area.north) - c.area.south);
  const long double column = ((x - c.layer.grid.origin_x) / c.layer.grid.step_x + c.layer.data.x) * scale;
  const long double row = ((c.layer.grid.origin_y - y) / c.layer.grid.step_y + c.layer.data.y) * scale;
  return {(column - tile.x) / tile_texels, (row - tile.y) / tile_texels};
}

// What OpenGL computes: coordinates and matrix in float.
double in_float(double scale, double trans, double offset) {
  return static_cast<double>(static_cast<float>(scale) * static_cast<float>(offset) + static_cast<float>(trans));
}

TEST(TileMatrix, LocalCoordinatesInFloatStayWithinAHundredthOfATexelUpToVt31) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> anywhere(0.05, 0.95);
  double worst = 0.0;
  for (int vt = 10; vt <= 31; ++vt) {
    const Case c = random_case(random, vt);
    const VtMapping mapping(c.area, c.layer);
    const auto layout = make_layout(c.layer, {.tile_exponent = 9, .overrides = {}});
    ASSERT_TRUE(layout.has_value());
    for (const LevelLayout& level : layout->levels) {
      for (int trial = 0; trial < 50; ++trial) {
        const double s = anywhere(random);
        const double t = anywhere(random);
        const TexelOrigin tile = box_origin(*layout, level, s, t);
        // A geometry of 64 texels somewhere in the tile, with its own origin.
        const double texels = static_cast<double>(level.tile_texels());
        const Point2 corner{static_cast<double>(tile.x) + anywhere(random) * texels * 0.8,
                            static_cast<double>(tile.y) + anywhere(random) * texels * 0.8};
        const Point2 uv_origin = mapping.uv_from_texel(level.level, corner);
        const TileMatrix m = tile_matrix(*layout, level, tile, mapping.st_from_uv(), uv_origin);
        for (int k = 0; k < 4; ++k) {
          const Point2 uv = mapping.uv_from_texel(level.level, {corner.x + anywhere(random) * 64, corner.y + anywhere(random) * 64});
          const auto [exact_x, exact_y] = exact_uv(c, level.level, tile, level.tile_texels(), uv.x, uv.y);
          const double x = in_float(m.scale_x, m.trans_x, uv.x - uv_origin.x);
          const double y = in_float(m.scale_y, m.trans_y, uv.y - uv_origin.y);
          worst =
              std::max({worst, static_cast<double>(std::abs(x - exact_x)) * texels, static_cast<double>(std::abs(y - exact_y)) * texels});
        }
      }
    }
  }
  EXPECT_LE(worst, 0.01);
  RecordProperty("worst_texels", std::to_string(worst));
}

TEST(TileMatrix, GlobalCoordinatesInFloatWouldNotDo) {
  // The reason for origins: without one, vt = 24 is a whole texel off. A test that could not tell the two
  // apart would prove nothing.
  std::mt19937_64 random(4);
  const Case c = random_case(random, 24);
  const VtMapping mapping(c.area, c.layer);
  const auto layout = make_layout(c.layer, {.tile_exponent = 9, .overrides = {}});
  const LevelLayout& level = layout->levels.front();
  double worst = 0.0;
  std::uniform_real_distribution<double> anywhere(0.3, 0.7);
  for (int trial = 0; trial < 1000; ++trial) {
    const TexelOrigin tile = box_origin(*layout, level, anywhere(random), anywhere(random));
    const Point2 uv = mapping.uv_from_texel(level.level, {static_cast<double>(tile.x) + 100.3, static_cast<double>(tile.y) + 77.7});
    const TileMatrix m = tile_matrix(*layout, level, tile, mapping.st_from_uv(), {});
    const auto exact = exact_uv(c, level.level, tile, 512, uv.x, uv.y);
    worst = std::max(worst, static_cast<double>(std::abs(in_float(m.scale_x, m.trans_x, uv.x) - exact.first)) * 512);
  }
  EXPECT_GT(worst, 0.1);
}

TEST(TileMatrix, InDoubleItIsEquationFiveToTheLastBits) {
  std::mt19937_64 random(5);
  for (int vt = 10; vt <= 31; ++vt) {
    const Case c = random_case(random, vt);
    const VtMapping mapping(c.area, c.layer);
    const auto layout = make_layout(c.layer, {.tile_exponent = 8, .overrides = {}});
    for (const LevelLayout& level : layout->levels) {
      const TexelOrigin tile = box_origin(*layout, level, 0.41, 0.63);
      const Point2 uv_origin{0.4, 0.6};
      const TileMatrix m = tile_matrix(*layout, level, tile, mapping.st_from_uv(), uv_origin);
      for (const double d : {-1e-6, 0.0, 3e-7}) {
        const auto exact = exact_uv(c, level.level, tile, level.tile_texels(), 0.4L + d, 0.6L + d);
        // A few roundings of numbers up to 2^vt texels wide.
        const double tolerance = std::ldexp(1.0, vt - 50);
        EXPECT_NEAR(m.scale_x * d + m.trans_x, static_cast<double>(exact.first), tolerance) << "vt " << vt;
        EXPECT_NEAR(m.scale_y * d + m.trans_y, static_cast<double>(exact.second), tolerance) << "vt " << vt;
      }
    }
  }
}

// --- The paging grid -----------------------------------------------------------------------------------------------------------------

LayerInfo plain_layer(int finest, TexelRect data = {}, TexelFormat format = TexelFormat::kRgb8) {
  return test::layer_info({.format = format, .tile_exponent = 8, .finest = finest, .data = data, .paint = {}, .skip = {}}, {});
}

TEST(Layout, CoarsestLevelIsOneTileOverEverything) {
  for (int finest = 0; finest <= 12; ++finest)
    for (int exponent = 3; exponent <= 12; ++exponent)
      for (int n = 1; n <= 8; n += 3) {
        const auto layout = make_layout(plain_layer(finest), {.tile_exponent = exponent, .tiles_per_side = n, .overrides = {}});
        ASSERT_TRUE(layout.has_value());
        const LevelLayout& last = layout->levels.back();
        EXPECT_EQ(last.tiles_per_side, 1);
        EXPECT_EQ(last.tile_texels(), layout->width(last.level));
        EXPECT_EQ(box_at(*layout, last.level, box_origin(*layout, last, 0.9, 0.1), last.tile_texels()), (Box{0, 0, 1, 1}));
      }
}

TEST(Layout, EveryMipOfEveryTileLiesOnTheTexelsOfItsOwnLevel) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> anywhere(-0.2, 1.2);
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kBc1})
    for (int n = 1; n <= 4; ++n)
      for (int exponent = 5; exponent <= 10; ++exponent) {
        const auto layout = make_layout(plain_layer(9, {}, format), {.tile_exponent = exponent, .tiles_per_side = n, .overrides = {}});
        ASSERT_TRUE(layout.has_value());
        for (const LevelLayout& level : layout->levels) {
          EXPECT_LE(level.mips, level.level.value + 1);
          for (int trial = 0; trial < 20; ++trial) {
            const TexelOrigin origin = box_origin(*layout, level, anywhere(random), anywhere(random));
            const std::int64_t grid = (std::int64_t{1} << (level.mips - 1)) * format_info(format).block_edge;
            EXPECT_EQ(origin.x % grid, 0);
            EXPECT_EQ(origin.y % grid, 0);
            EXPECT_GE(level.tile_texels() >> (level.mips - 1), format_info(format).block_edge);
          }
        }
      }
}

TEST(Layout, LevelsMayDiffer) {
  const auto layout =
      make_layout(plain_layer(8),
                  {.tile_exponent = 8,
                   .overrides = {{.level = Level{8}, .tile_exponent = 10, .tiles_per_side = 2}, {.level = Level{6}, .tiles_per_side = 8}}});
  ASSERT_TRUE(layout.has_value());
  EXPECT_EQ(layout->levels[0].tile_exponent, 10);
  EXPECT_EQ(layout->levels[0].tiles_per_side, 2);
  EXPECT_EQ(layout->levels[1].tile_exponent, 8);
  EXPECT_EQ(layout->levels[2].tiles_per_side, 8);
  // Close to the root there are not so many tiles.
  const auto wide = make_layout(plain_layer(2), {.tile_exponent = 8, .tiles_per_side = 8, .overrides = {}});
  ASSERT_EQ(wide->levels.size(), 3U);
  EXPECT_EQ(wide->levels[0].tiles_per_side, 4);
  EXPECT_EQ(wide->levels[1].tiles_per_side, 2);
}

TEST(Layout, RefusesImpossibleWishes) {
  EXPECT_FALSE(make_layout(plain_layer(8), {.tile_exponent = 2, .overrides = {}}));
  EXPECT_FALSE(make_layout(plain_layer(8), {.tile_exponent = 14, .overrides = {}}));
  EXPECT_FALSE(make_layout(plain_layer(8), {.tiles_per_side = 9, .overrides = {}}));
  EXPECT_FALSE(make_layout(plain_layer(8), {.hop_texels = 100, .overrides = {}}));
}

TEST(BoxOrigin, StaysInsideTheSquareAndHoldsTheCenterWhereDataAllows) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(-0.5, 1.5);
  const TexelRect data{300, 1000, 40001, 30011};
  const auto layout = make_layout(plain_layer(8, data), {.tile_exponent = 9, .tiles_per_side = 3, .overrides = {}});
  for (const LevelLayout& level : layout->levels) {
    const std::int64_t width = layout->width(level.level);
    const TexelRect here = coarser(data, 8 - level.level.value);
    for (int trial = 0; trial < 2000; ++trial) {
      const double s = anywhere(random);
      const double t = anywhere(random);
      const TexelOrigin origin = box_origin(*layout, level, s, t);
      ASSERT_GE(origin.x, 0);
      ASSERT_GE(origin.y, 0);
      ASSERT_LE(origin.x + level.box_texels(), width);
      ASSERT_LE(origin.y + level.box_texels(), width);
      // A center on data is inside the box.
      const auto x = static_cast<std::int64_t>(std::floor(s * static_cast<double>(width)));
      const auto y = static_cast<std::int64_t>(std::floor((1.0 - t) * static_cast<double>(width)));
      if (!here.contains(x, y)) continue;
      ASSERT_TRUE((TexelRect{origin.x, origin.y, level.box_texels(), level.box_texels()}.contains(x, y)));
    }
  }
}

TEST(BoxOrigin, EveryTexelOfDataCanBeReached) {
  const auto layout = make_layout(plain_layer(4, {0, 0, 600, 601}), {.tile_exponent = 9, .overrides = {}});
  const LevelLayout& level = layout->levels.front();
  EXPECT_EQ(box_origin(*layout, level, 0.0, 1.0), (TexelOrigin{0, 0}));
  const TexelOrigin last = box_origin(*layout, level, 1.0, 0.0);
  EXPECT_GE(last.x + level.tile_texels(), 600);
  EXPECT_GE(last.y + level.tile_texels(), 601);
}

TEST(BoxOrigin, KeepsItsPlaceWhileTheCenterSwingsOverAGridLine) {
  const auto layout = make_layout(plain_layer(8), {.tile_exponent = 9, .overrides = {}});
  const LevelLayout& level = layout->levels.front();
  const double texel = 1.0 / 65536;
  // Exactly between two grid places.
  const double s = (20000 / 256 * 256 + 128) * texel;
  TexelOrigin at = box_origin(*layout, level, s - 10 * texel, 0.5);
  int hops = 0;
  for (int i = 0; i < 1000; ++i) {
    const TexelOrigin next = box_origin(*layout, level, s + (i % 2 == 0 ? 50 : -50) * texel, 0.5, &at);
    hops += next == at ? 0 : 1;
    at = next;
  }
  EXPECT_EQ(hops, 0);
  // Without memory it would hop every time.
  EXPECT_NE(box_origin(*layout, level, s + 50 * texel, 0.5), box_origin(*layout, level, s - 50 * texel, 0.5));
}

}  // namespace
}  // namespace vt::runtime
