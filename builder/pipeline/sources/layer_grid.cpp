#include "builder/pipeline/sources/layer_grid.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <string>

namespace vt::pipeline {
namespace {

using source::RasterInfo;

// Texel size in the layer's CRS that keeps the source's own resolution at its centre.
Result<Point2> native_step(const geo::Crs& crs, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const geo::GeoTransform& transform = source.transform;
  const Point2 centre{static_cast<double>(info.width) / 2, static_cast<double>(info.height) / 2};
  VT_ASSIGN(const Point2 here, convert(crs, source.crs, transform.crs_from_raster(centre)));
  VT_ASSIGN(const Point2 east, convert(crs, source.crs, transform.crs_from_raster({centre.x + 1, centre.y})));
  VT_ASSIGN(const Point2 south, convert(crs, source.crs, transform.crs_from_raster({centre.x, centre.y + 1})));
  return Point2{std::hypot(east.x - here.x, south.x - here.x), std::hypot(east.y - here.y, south.y - here.y)};
}

// A ground sample distance in CRS units: metres of the grid where the CRS is projected (a UTM image "of 0.5
// m" has texels of 0.5 grid metres), metres on the ground at the centre where it is in degrees.
Result<Point2> step_of_gsd(const geo::Crs& crs, double gsd_m, const Bounds& bounds) {
  if (!(gsd_m > 0.0) || !std::isfinite(gsd_m)) return fail(ErrorCode::kUsage, "the ground sample distance must be greater than 0 metres");
  switch (crs.kind()) {
    case geo::CrsKind::kPixel:
      return Point2{gsd_m, gsd_m};
    case geo::CrsKind::kProjected:
      return Point2{gsd_m / crs.definition().metres_per_unit, gsd_m / crs.definition().metres_per_unit};
    case geo::CrsKind::kGeographic:
      break;
  }
  VT_ASSIGN(const Point2 metres, crs.metres_per_unit_at({(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2}));
  return Point2{gsd_m / metres.x, gsd_m / metres.y};
}

// Edges that reach to the far side of the Earth do not enclose what lies between them.
bool is_on_near_side(const geo::NearSide& near, const Bounds& longitudes) {
  const double turns = std::round(((longitudes.west + longitudes.east) / 2 - near.central_deg) / 360.0);
  return longitudes.west - 360.0 * turns > near.central_deg - near.reach_deg &&
         longitudes.east - 360.0 * turns < near.central_deg + near.reach_deg;
}

// Adds what the edges of a raster around a pole do not show: all longitudes, and the pole itself.
void add_poles(const geo::Crs& crs, const OpenSource& source, Bounds& bounds) {
  const auto near = source.crs.near_side();
  const auto raster_from_crs = source.transform.inverse();
  if (!crs.turn() || !near || !raster_from_crs) return;
  const RasterInfo& info = source.raster->info();
  const double meridian_deg = near->central_deg;
  for (const double latitude_deg : {-90.0, 90.0}) {
    const auto pole = source.crs.crs_from_lonlat({meridian_deg, latitude_deg});
    if (!pole) continue;
    const Point2 place = raster_from_crs->apply(*pole);
    const bool is_inside =
        place.x >= 0.0 && place.y >= 0.0 && place.x <= static_cast<double>(info.width) && place.y <= static_cast<double>(info.height);
    if (!is_inside) continue;
    for (const double longitude_deg : {meridian_deg - 180.0, meridian_deg + 180.0})
      if (const auto corner = crs.crs_from_lonlat({longitude_deg, latitude_deg})) bounds.add(*corner);
  }
}

}  // namespace

Result<Point2> convert(const geo::Crs& to, const geo::Crs& from, Point2 p) {
  if (to.same_coordinates(from)) return p;
  VT_ASSIGN(const Point2 lonlat, from.unwrapped_lonlat_from_crs(p));
  return to.crs_from_lonlat(lonlat);
}

void Bounds::add(Point2 p) {
  west = std::min(west, p.x);
  east = std::max(east, p.x);
  south = std::min(south, p.y);
  north = std::max(north, p.y);
}

void Bounds::add(const Bounds& other) {
  add(Point2{other.west, other.south});
  add(Point2{other.east, other.north});
}

// Edges may bulge when reprojected, so they are followed in small steps: 32 samples of a small raster, 1/64
// of the edge of a large one.
Result<Bounds> bounds_in(const geo::Crs& crs, const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  const geo::GeoTransform& transform = source.transform;
  const auto follow = static_cast<int>(std::clamp<std::int64_t>(std::max(info.width, info.height) / 32, 4, 64));
  const int steps = crs.same_coordinates(source.crs) ? 1 : follow;
  const auto width = static_cast<double>(info.width);
  const auto height = static_cast<double>(info.height);
  Bounds bounds;
  Bounds longitudes;  // and latitudes, where they matter
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    for (const Point2 corner : {Point2{f * width, 0.0}, Point2{f * width, height}, Point2{0.0, f * height}, Point2{width, f * height}}) {
      auto p = convert(crs, source.crs, transform.crs_from_raster(corner));
      if (!p)
        return fail(ErrorCode::kInvalidData,
                    source.request.path.string() + ": cannot be placed in " + crs.text() + ": " + p.error().message);
      bounds.add(*p);
      if (const auto lonlat = source.crs.unwrapped_lonlat_from_crs(transform.crs_from_raster(corner))) longitudes.add(*lonlat);
    }
  }
  const auto near = crs.near_side();
  if (near && !crs.same_coordinates(source.crs) && !is_on_near_side(*near, longitudes))
    return fail(ErrorCode::kInvalidData, source.request.path.string() + ": cannot be placed in " + crs.text() +
                                             ": it reaches to the far side of the Earth, more than " +
                                             std::to_string(std::lround(near->reach_deg)) + " degrees from its central meridian; " +
                                             "`area` says which part of it is wanted");
  add_poles(crs, source, bounds);
  return bounds;
}

Result<GridPlacement> choose_grid(const LayerRequest& request, const geo::Crs& crs, const OpenSource* first, double first_moved_x,
                                  const Bounds& bounds) {
  GridPlacement grid;
  std::optional<Point2> step;
  if (request.gsd_m) {
    VT_ASSIGN(step, step_of_gsd(crs, *request.gsd_m, bounds));
  }
  const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-6 * b; };
  if (first != nullptr && first->transform.is_north_up() && crs.same_coordinates(first->crs)) {
    geo::GeoTransform transform = first->transform;
    transform.x0 += first_moved_x;
    if (!step || (same(step->x, transform.x_column) && same(step->y, -transform.y_row))) {
      grid.step_x = transform.x_column;
      grid.step_y = -transform.y_row;
      // On the first source's own grid lines, moved outward by whole texels to cover the others.
      grid.origin_x = transform.x0 + std::floor((bounds.west - transform.x0) / grid.step_x + kGridTolerance) * grid.step_x;
      grid.origin_y = transform.y0 - std::floor((transform.y0 - bounds.north) / grid.step_y + kGridTolerance) * grid.step_y;
      return grid;
    }
  }
  if (!step && first == nullptr) return fail(ErrorCode::kUsage, "without sources the ground sample distance has to be given");
  if (!step) {
    VT_ASSIGN(step, native_step(crs, *first));
  }
  grid.step_x = step->x;
  grid.step_y = step->y;
  grid.origin_x = bounds.west;
  grid.origin_y = bounds.north;
  return grid;
}

Result<void> set_size(const Bounds& bounds, LayerInfo& info) {
  const double columns = (bounds.east - info.grid.origin_x) / info.grid.step_x;
  const double rows = (info.grid.origin_y - bounds.south) / info.grid.step_y;
  const double limit = std::ldexp(1.0, kMaxVtExponent);
  if (!(columns > 0.0) || !(rows > 0.0) || columns > limit || rows > limit)
    return fail(ErrorCode::kInvalidData, "the finest level would have " + std::to_string(columns) + " x " + std::to_string(rows) +
                                             " texels; 1 to 2^31 are possible. Check `gsd`, `crs`, `area` and `extent`");
  info.data.width = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(columns - kGridTolerance)));
  info.data.height = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(rows - kGridTolerance)));
  const std::int64_t longest = std::max(info.data.width, info.data.height);
  info.finest.value = 0;
  while ((std::int64_t{1} << info.vt_exponent()) < longest) ++info.finest.value;
  if (info.vt_exponent() > kMaxVtExponent)
    return fail(ErrorCode::kInvalidData, "the finest level needs more than 2^31 texels along an edge");
  return {};
}

bool closes_around_globe(const geo::Crs& crs, std::int64_t width, double step_x) {
  constexpr double kTexels = 1e-3;
  return crs.turn() && std::abs(static_cast<double>(width) - *crs.turn() / step_x) <= kTexels;
}

}  // namespace vt::pipeline
