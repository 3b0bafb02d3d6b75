// Where raster columns and rows lie in a coordinate reference system. Pure arithmetic, any thread.
#pragma once

#include <optional>

#include "store/vt_mapping.h"

namespace vt::geo {

// x = x0 + column * x_column + row * x_row, y likewise; (column, row) = (0, 0) is the OUTER corner of the
// first sample, for PixelIsPoint files too.
struct GeoTransform {
  double x0 = 0.0;
  double x_column = 1.0;
  double x_row = 0.0;
  double y0 = 0.0;
  double y_column = 0.0;
  double y_row = -1.0;

  [[nodiscard]] Point2 crs_from_raster(Point2 column_row) const;
  [[nodiscard]] std::optional<GeoTransform> inverse() const;  // nullopt when it is singular
  [[nodiscard]] Point2 apply(Point2 p) const { return crs_from_raster(p); }
  // Columns run exactly east and rows exactly south: the raster's own grid can be a layer's grid.
  [[nodiscard]] bool is_north_up() const { return x_row == 0.0 && y_column == 0.0 && x_column > 0.0 && y_row < 0.0; }
};

}  // namespace vt::geo
