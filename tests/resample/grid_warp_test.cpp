#include "builder/resample/grid_warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace vt::resample {
namespace {

TEST(GridWarp, TheLatticeAgreesWithTheProjections) {
  const geo::Crs utm = geo::Crs::from_epsg(32633).value();
  const geo::Crs geographic = geo::Crs::from_epsg(4326).value();
  // Far from the central meridian and far north, where the map bends most.
  const GridWarp warp({22.0, 70.0, 0.002, 0.001}, geographic, {900000.0, 30.0, 0.0, 7900000.0, 0.0, -30.0}, utm);
  const TexelRect rect{5, 11, 100, 90};
  std::vector<Point2> positions(static_cast<std::size_t>(rect.width * rect.height));
  warp.map_centres(rect, positions);
  for (std::int64_t y = 0; y < rect.height; ++y)
    for (std::int64_t x = 0; x < rect.width; ++x) {
      const Point2 exact = warp.exact({static_cast<double>(rect.x + x) + 0.5, static_cast<double>(rect.y + y) + 0.5});
      const Point2& found = positions[static_cast<std::size_t>(y * rect.width + x)];
      // The cell's centre is checked; elsewhere in the cell a smooth map errs no more than a little beyond that.
      ASSERT_NEAR(found.x, exact.x, 2 * GridWarp::kTolerance);
      ASSERT_NEAR(found.y, exact.y, 2 * GridWarp::kTolerance);
    }
  // Cutting the work differently gives the same positions, bit for bit.
  std::vector<Point2> one(1);
  for (const auto& [x, y] : {std::pair{5, 11}, {63, 40}, {64, 64}, {104, 100}}) {
    warp.map_centres({x, y, 1, 1}, one);
    const Point2& in_rect = positions[static_cast<std::size_t>((y - rect.y) * rect.width + (x - rect.x))];
    EXPECT_EQ(one[0].x, in_rect.x);
    EXPECT_EQ(one[0].y, in_rect.y);
  }
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
