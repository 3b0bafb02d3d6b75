#include "builder/resample/grid/grid_warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace vt::resample {
namespace {

struct Pair {
  const char* name;
  int grid_epsg;
  GridPlacement grid;
  int source_epsg;
  geo::GeoTransform source;
};

// Grids far from where their projections are true, with texels about as large as samples. Between conformal
// systems both coordinates of the map are harmonic: what a test in the middle of a cell sees of the error
// cancels.
std::vector<Pair> pairs() {
  const auto utm = [](double x, double y, double step) { return geo::GeoTransform{x, step, 0.0, y, 0.0, -step}; };
  return {
      {"UTM to degrees, far north and east", 4326, {22.0, 70.0, 0.002, 0.001}, 32633, utm(900000, 7900000, 30)},
      {"UTM of 1 km to degrees", 4326, {12.0, 52.3, 0.0145, 0.009}, 32633, utm(300000, 5800000, 1000)},
      {"UTM of 250 m to Web Mercator", 3857, {1300000, 7900000, 460, 460}, 32633, utm(300000, 6400000, 250)},
      {"UTM of 1 km to Web Mercator", 3857, {1300000, 12100000, 3400, 3400}, 32633, utm(300000, 8100000, 1000)},
      {"UTM of 10 km to Web Mercator", 3857, {300000, 13500000, 14000, 14000}, 32633, utm(-500000, 8500000, 10000)},
      {"UTM of 10 km to the next zone", 32632, {400000, 7800000, 10000, 10000}, 32633, utm(0, 7800000, 10000)},
      {"one zone of 10 m to the next", 32632, {700000, 5500000, 10, 10}, 32633, utm(280000, 5500000, 10)},
      {"Web Mercator to degrees", 4326, {-180.0, 84.0, 0.9, 0.5}, 3857, {-2e7, 1e5, 0.0, 2e7, 0.0, -1e5}},
  };
}

TEST(GridWarp, EveryTexelLiesWhereTheProjectionsPutIt) {
  for (const Pair& pair : pairs()) {
    const GridWarp warp(pair.grid, geo::Crs::from_epsg(pair.grid_epsg).value(), pair.source, geo::Crs::from_epsg(pair.source_epsg).value());
    const TexelRect rect{5, 11, 200, 180};
    std::vector<Point2> centres(static_cast<std::size_t>(rect.width * rect.height));
    std::vector<Point2> corners(static_cast<std::size_t>((rect.width + 1) * (rect.height + 1)));
    std::vector<GridWarp::Patch> patches;
    warp.map_centres(rect, centres, &patches);
    warp.map_corners(rect, corners);
    const auto expect_near = [&](const Point2& found, double x, double y) {
      const Point2 exact = warp.exact({x, y});
      if (std::isnan(exact.x)) return;
      // Samples under a texel, for a tolerance of texels where these are larger.
      const Point2 next = warp.exact({x + 1, y});
      const Point2 below = warp.exact({x, y + 1});
      const double size = std::max({1.0, std::hypot(next.x - exact.x, next.y - exact.y), std::hypot(below.x - exact.x, below.y - exact.y)});
      // Places of a cell beside the four that were tested may err by a little more: 1.03 times for the
      // leading terms.
      ASSERT_NEAR(found.x, exact.x, 1.1 * GridWarp::kTolerance * size) << pair.name << " " << x << "," << y;
      ASSERT_NEAR(found.y, exact.y, 1.1 * GridWarp::kTolerance * size) << pair.name << " " << x << "," << y;
    };
    for (std::int64_t y = 0; y <= rect.height; ++y)
      for (std::int64_t x = 0; x <= rect.width; ++x) {
        const auto column = static_cast<double>(rect.x + x);
        const auto row = static_cast<double>(rect.y + y);
        expect_near(corners[static_cast<std::size_t>(y * (rect.width + 1) + x)], column, row);
        if (x < rect.width && y < rect.height) expect_near(centres[static_cast<std::size_t>(y * rect.width + x)], column + 0.5, row + 0.5);
      }
    // Cutting the work differently gives the same positions, bit for bit.
    std::vector<Point2> one(1);
    std::vector<Point2> four(4);
    for (const auto& [x, y] : {std::pair{5, 11}, {63, 40}, {64, 64}, {104, 100}, {204, 190}}) {
      warp.map_centres({x, y, 1, 1}, one);
      const Point2& in_rect = centres[static_cast<std::size_t>((y - rect.y) * rect.width + (x - rect.x))];
      EXPECT_EQ(one[0].x, in_rect.x) << pair.name;
      EXPECT_EQ(one[0].y, in_rect.y) << pair.name;
      warp.map_corners({x, y, 1, 1}, four);
      const Point2& south_east = corners[static_cast<std::size_t>((y + 1 - rect.y) * (rect.width + 1) + (x + 1 - rect.x))];
      EXPECT_EQ(four[3].x, south_east.x) << pair.name;
      EXPECT_EQ(four[3].y, south_east.y) << pair.name;
    }
    // The patches cover the rectangle once, and say how coarse the map is there.
    std::vector<int> times(centres.size(), 0);
    const double most = warp.most_samples_per_texel(rect);
    for (const GridWarp::Patch& patch : patches)
      for (std::int64_t y = patch.texels.y; y < patch.texels.bottom(); ++y)
        for (std::int64_t x = patch.texels.x; x < patch.texels.right(); ++x) {
          ASSERT_TRUE(rect.contains(x, y));
          ++times[static_cast<std::size_t>((y - rect.y) * rect.width + (x - rect.x))];
          const Point2 west = warp.exact({static_cast<double>(x), y + 0.5});
          const Point2 east = warp.exact({x + 1.0, y + 0.5});
          if (std::isnan(west.x) || std::isnan(east.x)) continue;
          ASSERT_GE(patch.samples_per_texel, std::hypot(east.x - west.x, east.y - west.y) * 0.98) << pair.name;
          ASSERT_LE(patch.samples_per_texel, most * 1.1) << pair.name << ": of cells that reach beyond the rectangle";
        }
    EXPECT_EQ(std::ranges::count(times, 1), static_cast<std::ptrdiff_t>(times.size())) << pair.name;
  }
}

TEST(GridWarp, RastersOfOneGridKnowTheirOffset) {
  const geo::Crs utm = geo::Crs::from_epsg(32633).value();
  const GridPlacement grid{500000.0, 5400000.0, 7.0, 7.0};
  const geo::GeoTransform north_up{500003.0, 10.0, 0.0, 5400001.0, 0.0, -10.0};
  const geo::GeoTransform turned{500003.0, 8.0, 6.0, 5400001.0, 6.0, -8.0};
  for (const geo::GeoTransform& transform : {north_up, turned}) {
    const GridWarp first(grid, utm, transform, utm);
    const auto moved = [&](double columns, double rows, double scale = 1.0) {
      geo::GeoTransform other = transform;
      const Point2 corner = transform.crs_from_raster({columns, rows});
      other.x0 = corner.x;
      other.y0 = corner.y;
      other.x_column *= scale;
      return GridWarp(grid, utm, other, utm);
    };
    const auto offset = first.offset_of(moved(300, -200), 100, 80);
    ASSERT_TRUE(offset.has_value());
    EXPECT_EQ(offset->x, 300);
    EXPECT_EQ(offset->y, -200);
    EXPECT_TRUE(first.offset_of(moved(300 + 5e-5, -200), 100, 80).has_value()) << "as far as coordinates are written";
    EXPECT_FALSE(first.offset_of(moved(300.01, -200), 100, 80).has_value());
    EXPECT_FALSE(first.offset_of(moved(300, -200, 1.0 + 1e-5), 100, 80).has_value()) << "the far end is off by a thousandth of a sample";
    EXPECT_FALSE(first.offset_of(GridWarp(grid, utm, transform, geo::Crs::from_epsg(32632).value()), 100, 80).has_value());
  }
}

// A source that lies in a layer in two turns of the globe is two rasters, as far apart as a turn has samples.
// Where its own system has no turns, they never are one raster: the samples would have the same places.
TEST(GridWarp, RastersInOtherTurnsAreATurnApart) {
  const geo::Crs degrees = geo::Crs::from_epsg(4326).value();
  const GridPlacement grid{-190.0, 60.0, 0.7, 0.7};
  const geo::GeoTransform west{-180.0, 0.5, 0.0, 60.0, 0.0, -0.5};
  const geo::GeoTransform east{170.0, 0.5, 0.0, 60.0, 0.0, -0.5};
  for (const int epsg : {4326, 3857}) {
    const geo::Crs layer = geo::Crs::from_epsg(epsg).value();
    const GridWarp here(grid, layer, west, degrees);
    for (const int turns : {-1, 1, 2}) {
      const auto itself = here.offset_of(GridWarp(grid, layer, west, degrees, turns), 40, 40);
      ASSERT_TRUE(itself.has_value()) << turns;
      EXPECT_EQ(itself->x, 720 * turns);
      EXPECT_EQ(itself->y, 0);
    }
    // 170 degrees east, one turn to the west, is ten degrees beside it.
    const auto neighbour = here.offset_of(GridWarp(grid, layer, east, degrees, -1), 40, 40);
    ASSERT_TRUE(neighbour.has_value());
    EXPECT_EQ(neighbour->x, -20);
    const auto same_turn = GridWarp(grid, layer, west, degrees, 1).offset_of(GridWarp(grid, layer, east, degrees, 1), 40, 40);
    ASSERT_TRUE(same_turn.has_value());
    EXPECT_EQ(same_turn->x, 700);
  }
  const geo::Crs utm = geo::Crs::from_epsg(32660).value();
  const geo::GeoTransform metres{500000.0, 1000.0, 0.0, 5400000.0, 0.0, -1000.0};
  const GridWarp first(grid, degrees, metres, utm);
  EXPECT_FALSE(first.offset_of(GridWarp(grid, degrees, metres, utm, -1), 40, 40).has_value());
  EXPECT_TRUE(first.offset_of(GridWarp(grid, degrees, metres, utm), 40, 40).has_value());
}

TEST(GridWarp, OneCoordinateSystemIsOneAffineMap) {
  // Texels of 3 by 2 units from (100, 200); samples of 2 by 2 turned by 30 degrees about (90, 210).
  const double c = std::cos(0.5235987755982988) * 2.0;
  const double s = std::sin(0.5235987755982988) * 2.0;
  const geo::GeoTransform turned{90.0, c, s, 210.0, s, -c};
  const GridWarp warp({100.0, 200.0, 3.0, 2.0}, geo::Crs(), turned, geo::Crs());
  std::vector<Point2> positions(12);
  warp.map_centres({-2, 5, 4, 3}, positions);
  for (int i = 0; i < 12; ++i) {
    const Point2 back = turned.crs_from_raster(positions[static_cast<std::size_t>(i)]);
    // Double rounding of numbers around 100.
    EXPECT_NEAR(back.x, 100.0 + (-2 + i % 4 + 0.5) * 3.0, 1e-12);
    EXPECT_NEAR(back.y, 200.0 - (5 + i / 4 + 0.5) * 2.0, 1e-12);
  }
}

TEST(GridWarp, PlacesWithoutAnAnswerAreNotNumbers) {
  // A geographic grid that runs past the pole, seen from UTM.
  const GridWarp warp({10.0, 95.0, 1.0, 1.0}, geo::Crs::from_epsg(4326).value(), {500000.0, 1000.0, 0.0, 9000000.0, 0.0, -1000.0},
                      geo::Crs::from_epsg(32633).value());
  const Point2 beyond = warp.exact({0.5, 0.5});
  EXPECT_TRUE(std::isnan(beyond.x));
  EXPECT_TRUE(std::isnan(beyond.y));
  std::vector<Point2> positions(1);
  warp.map_centres({0, 0, 1, 1}, positions);
  EXPECT_TRUE(std::isnan(positions[0].x));
}

}  // namespace
}  // namespace vt::resample
