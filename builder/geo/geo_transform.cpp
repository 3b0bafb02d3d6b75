#include "builder/geo/geo_transform.h"

#include <cmath>

namespace vt::geo {

Point2 GeoTransform::crs_from_raster(Point2 column_row) const {
  return {.x = x0 + column_row.x * x_column + column_row.y * x_row, .y = y0 + column_row.x * y_column + column_row.y * y_row};
}

std::optional<GeoTransform> GeoTransform::inverse() const {
  const double determinant = x_column * y_row - x_row * y_column;
  if (!std::isfinite(determinant) || determinant == 0.0) return std::nullopt;
  GeoTransform result{.x0 = 0.0,
                      .x_column = y_row / determinant,
                      .x_row = -x_row / determinant,
                      .y0 = 0.0,
                      .y_column = -y_column / determinant,
                      .y_row = x_column / determinant};
  if (x_row == 0.0 && y_column == 0.0) {  // one division instead of three roundings
    result.x_column = 1.0 / x_column;
    result.y_row = 1.0 / y_row;
  }
  result.x0 = -(x0 * result.x_column + y0 * result.x_row);
  result.y0 = -(x0 * result.y_column + y0 * result.y_row);
  return result;
}

}  // namespace vt::geo
