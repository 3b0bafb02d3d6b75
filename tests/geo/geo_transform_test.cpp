#include "builder/geo/geo_transform.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vt::geo {
namespace {

TEST(GeoTransform, InverseUndoesAnyGridThatIsNotSingular) {
  const GeoTransform grids[] = {
      {.x0 = -123.0, .x_column = 0.0008333333333333334, .x_row = 0.0, .y0 = 50.0, .y_column = 0.0, .y_row = -0.0008333333333333334},
      {.x0 = 440720.0, .x_column = 60.0, .x_row = 0.0, .y0 = 3751320.0, .y_column = 0.0, .y_row = 60.0},  // south-up
      {.x0 = 500000.0, .x_column = 8.0, .x_row = 6.0, .y0 = 4500000.0, .y_column = 6.0, .y_row = -8.0},   // rotated
  };
  for (const GeoTransform& grid : grids) {
    const auto inverse = grid.inverse();
    ASSERT_TRUE(inverse.has_value());
    for (const Point2 raster : {Point2{0, 0}, Point2{1, 0}, Point2{0, 1}, Point2{12345.5, 9876.25}}) {
      const Point2 back = inverse->apply(grid.apply(raster));
      // x0 of 4.5e6 with steps of 10: half an ulp of the coordinate is 5e-10, a twentieth of that in samples;
      // a few such roundings.
      EXPECT_NEAR(back.x, raster.x, 1e-9 + 1e-12 * std::abs(grid.x0 / grid.x_column));
      EXPECT_NEAR(back.y, raster.y, 1e-9 + 1e-12 * std::abs(grid.y0 / grid.y_row));
    }
  }
}

TEST(GeoTransform, SingularGridsHaveNoInverse) {
  const GeoTransform flat{.x0 = 0, .x_column = 1, .x_row = 2, .y0 = 0, .y_column = 2, .y_row = 4};
  EXPECT_FALSE(flat.inverse().has_value());
  EXPECT_FALSE((GeoTransform{.x0 = 0, .x_column = NAN, .x_row = 0, .y0 = 0, .y_column = 0, .y_row = -1}.inverse().has_value()));
}

TEST(GeoTransform, OnlyExactlyNorthUpGridsSaySo) {
  EXPECT_TRUE(GeoTransform{}.is_north_up());
  EXPECT_FALSE((GeoTransform{.x0 = 0, .x_column = 1, .x_row = 0, .y0 = 0, .y_column = 0, .y_row = 1}.is_north_up()));
  EXPECT_FALSE((GeoTransform{.x0 = 0, .x_column = 1, .x_row = 1e-9, .y0 = 0, .y_column = 0, .y_row = -1}.is_north_up()));
}

}  // namespace
}  // namespace vt::geo
