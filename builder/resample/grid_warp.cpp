#include "builder/resample/grid_warp.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace vt::resample {
namespace {

std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }

Point2 bilinear(const Point2 corners[4], double fx, double fy) {
  const auto mix = [&](double a, double b, double c, double d) {
    return (a * (1 - fx) + b * fx) * (1 - fy) + (c * (1 - fx) + d * fx) * fy;
  };
  return {mix(corners[0].x, corners[1].x, corners[2].x, corners[3].x), mix(corners[0].y, corners[1].y, corners[2].y, corners[3].y)};
}

}  // namespace

GridWarp::GridWarp(const GridPlacement& grid, geo::Crs grid_crs, const geo::GeoTransform& source, geo::Crs source_crs, int turns)
    : grid_(grid),
      grid_crs_(std::move(grid_crs)),
      source_crs_(std::move(source_crs)),
      same_crs_(grid_crs_.same_coordinates(source_crs_)),
      moved_(turns * (same_crs_ ? grid_crs_.turn().value_or(0.0) : 360.0)) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  raster_from_source_crs_ = source.inverse().value_or(geo::GeoTransform{nan, nan, nan, nan, nan, nan});
  // JSON writes the shortest decimal that reads back as the same double.
  nlohmann::json facts = {
      {"grid", {grid.origin_x, grid.origin_y, grid.step_x, grid.step_y}},
      {"grid_crs", grid_crs_.to_json()},
      {"transform", {source.x0, source.x_column, source.x_row, source.y0, source.y_column, source.y_row}},
      {"source_crs", source_crs_.to_json()},
  };
  if (turns != 0) facts["turns"] = turns;
  facts_ = facts.dump();
}

Point2 GridWarp::exact(Point2 texel) const {
  Point2 crs{grid_.origin_x + texel.x * grid_.step_x, grid_.origin_y - texel.y * grid_.step_y};
  if (!same_crs_) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto lonlat = grid_crs_.unwrapped_lonlat_from_crs(crs);
    if (!lonlat) return {nan, nan};
    const auto source = source_crs_.crs_from_lonlat({lonlat->x - moved_, lonlat->y});
    if (!source) return {nan, nan};
    crs = *source;
  } else {
    crs.x -= moved_;
  }
  return raster_from_source_crs_.apply(crs);
}

void GridWarp::map_centres(const TexelRect& rect, std::span<Point2> out) const {
  if (same_crs_) {  // one affine map: nothing to approximate
    std::size_t next = 0;
    for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
      for (std::int64_t x = rect.x; x < rect.right(); ++x)
        out[next++] = exact({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
    return;
  }
  for (std::int64_t cell_y = floor_div(rect.y, kCell); cell_y * kCell < rect.bottom(); ++cell_y)
    for (std::int64_t cell_x = floor_div(rect.x, kCell); cell_x * kCell < rect.right(); ++cell_x)
      map_cell(cell_x, cell_y, intersect(rect, {cell_x * kCell, cell_y * kCell, kCell, kCell}), rect, out);
}

void GridWarp::map_cell(std::int64_t cell_x, std::int64_t cell_y, const TexelRect& part, const TexelRect& rect,
                        std::span<Point2> out) const {
  const auto x0 = static_cast<double>(cell_x * kCell);
  const auto y0 = static_cast<double>(cell_y * kCell);
  constexpr auto kEdge = static_cast<double>(kCell);
  const Point2 corners[4] = {exact({x0, y0}), exact({x0 + kEdge, y0}), exact({x0, y0 + kEdge}), exact({x0 + kEdge, y0 + kEdge})};
  const Point2 centre = exact({x0 + kEdge / 2, y0 + kEdge / 2});
  const Point2 guess = bilinear(corners, 0.5, 0.5);
  // The bilinear error of a smooth map is largest near the middle of a cell. NaN compares false and goes the exact way.
  const bool is_smooth = std::abs(guess.x - centre.x) <= kTolerance && std::abs(guess.y - centre.y) <= kTolerance;
  for (std::int64_t y = part.y; y < part.bottom(); ++y)
    for (std::int64_t x = part.x; x < part.right(); ++x) {
      const Point2 texel{static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5};
      out[static_cast<std::size_t>((y - rect.y) * rect.width + (x - rect.x))] =
          is_smooth ? bilinear(corners, (texel.x - x0) / kEdge, (texel.y - y0) / kEdge) : exact(texel);
    }
}

}  // namespace vt::resample
