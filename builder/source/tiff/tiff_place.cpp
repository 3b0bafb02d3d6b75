#include "builder/source/tiff/tiff_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "builder/source/metadata/geo_tags.h"

namespace vt::source {
namespace {

// Tie points and an affine map that miss each other by no more are the same place, written with few digits.
constexpr double kExactSamples = 1e-3;
// With fewer every affine map would fit, whatever was meant.
constexpr std::size_t kFewestTiePoints = 4;

constexpr const char* kBringOntoGrid = "bring it onto a grid first, for example with gdalwarp -r bilinear in.tif new.tif";

struct TiePoint {
  Point2 raster;  // column, row
  Point2 crs;
};

// Six numbers each: column, row, an unused one, x, y, z.
std::vector<TiePoint> tie_points(const std::vector<double>& numbers) {
  std::vector<TiePoint> points;
  for (std::size_t at = 0; at + 6 <= numbers.size(); at += 6)
    points.push_back({.raster = {numbers[at], numbers[at + 1]}, .crs = {numbers[at + 3], numbers[at + 4]}});
  return points;
}

// The farthest of the points from where the map puts it, in samples.
double worst_miss(const std::vector<TiePoint>& points, const geo::GeoTransform& transform) {
  const auto inverse = transform.inverse();
  if (!inverse) return INFINITY;
  double worst = 0.0;
  for (const TiePoint& point : points) {
    const Point2 place = inverse->apply(point.crs);
    worst = std::max(worst, std::hypot(place.x - point.raster.x, place.y - point.raster.y));
  }
  return std::isfinite(worst) ? worst : INFINITY;
}

// The affine map with the least squared error; nullopt when the points lie on one line. Sums about the means
// in extended precision: points that lie exactly on a grid give exactly that grid.
std::optional<geo::GeoTransform> fitted(const std::vector<TiePoint>& points) {
  std::array<long double, 4> mean{};
  for (const TiePoint& p : points) {
    mean[0] += p.raster.x;
    mean[1] += p.raster.y;
    mean[2] += p.crs.x;
    mean[3] += p.crs.y;
  }
  for (long double& m : mean) m /= static_cast<long double>(points.size());
  long double uu = 0.0L;
  long double uv = 0.0L;
  long double vv = 0.0L;
  std::array<long double, 2> u_with{};  // x, y
  std::array<long double, 2> v_with{};
  double reach = 0.0;  // of the points about their mean, samples
  for (const TiePoint& p : points) {
    const long double u = p.raster.x - mean[0];
    const long double v = p.raster.y - mean[1];
    const std::array<long double, 2> value = {p.crs.x - mean[2], p.crs.y - mean[3]};
    uu += u * u;
    uv += u * v;
    vv += v * v;
    for (std::size_t i = 0; i < 2; ++i) {
      u_with[i] += u * value[i];
      v_with[i] += v * value[i];
    }
    reach = std::max({reach, static_cast<double>(std::abs(u)), static_cast<double>(std::abs(v))});
  }
  const long double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-9L * (uu + vv) * (uu + vv))) return std::nullopt;
  const auto by_column = [&](std::size_t i) { return (u_with[i] * vv - v_with[i] * uv) / determinant; };
  const auto by_row = [&](std::size_t i) { return (v_with[i] * uu - u_with[i] * uv) / determinant; };
  std::array<long double, 2> column = {by_column(0), by_column(1)};
  std::array<long double, 2> row = {by_row(0), by_row(1)};
  // Rotations that move no point by as much as rounding may are none.
  const auto is_nothing = [&](long double off_axis, long double on_axis) {
    return std::abs(off_axis) * reach <= kExactSamples * std::abs(on_axis);
  };
  if (is_nothing(column[1], row[1]) && is_nothing(row[0], column[0])) column[1] = row[0] = 0.0L;
  const auto origin = [&](std::size_t i) { return static_cast<double>(mean[2 + i] - column[i] * mean[0] - row[i] * mean[1]); };
  return geo::GeoTransform{.x0 = origin(0),
                           .x_column = static_cast<double>(column[0]),
                           .x_row = static_cast<double>(row[0]),
                           .y0 = origin(1),
                           .y_column = static_cast<double>(column[1]),
                           .y_row = static_cast<double>(row[1])};
}

// From tie points alone.
void place_by_tie_points(const std::vector<TiePoint>& points, TiffPlace& place) {
  const std::string count = points.size() == 1 ? "one tie point" : fmt::format("{} tie points", points.size());
  if (points.size() < kFewestTiePoints) {
    place.problem = fmt::format(
        "{} (tag 33922) without a sample size (tag 33550) {} where it lies; write the size into the file, for example "
        "with gdal_edit.py -a_ullr WEST NORTH EAST SOUTH in.tif",
        count, points.size() == 1 ? "does not say" : "do not say for certain");
    return;
  }
  const auto transform = fitted(points);
  if (!transform || !transform->inverse()) {
    place.problem = fmt::format("its {} (tag 33922) lie on one line, which is no place for a raster", count);
    return;
  }
  const double miss = worst_miss(points, *transform);
  if (miss > kExactSamples) {
    place.problem = fmt::format("its {} (tag 33922) do not lie on one grid: the nearest one misses them by up to {:.3g} samples; {}", count,
                                miss, kBringOntoGrid);
    return;
  }
  place.transform = transform;
}

// From a sample size and a tie point.
void place_by_scale(const std::vector<double>& scale, const std::vector<TiePoint>& points, TiffPlace& place) {
  // Rows run south by definition; a negative scale is taken for a writer's slip, as GDAL does.
  const double x_step = scale[0];
  const double y_step = -std::abs(scale[1]);
  const TiePoint& tie = points.front();
  place.transform = geo::GeoTransform{.x0 = tie.crs.x - tie.raster.x * x_step,
                                      .x_column = x_step,
                                      .x_row = 0.0,
                                      .y0 = tie.crs.y - tie.raster.y * y_step,
                                      .y_column = 0.0,
                                      .y_row = y_step};
  if (scale[1] < 0.0)
    place.unused.push_back({.what = "a negative ScaleY (tag 33550)",
                            .instead =
                                "rows are taken to run from north to south, as GDAL takes them. If they run north, write that into the "
                                "file first: gdal_translate --config GTIFF_HONOUR_NEGATIVE_SCALEY YES in.tif new.tif"});
  if (points.size() > 1 && worst_miss(points, *place.transform) > 0.5)
    place.unused.push_back({.what = "tie points (tag 33922) that contradict the sample size (tag 33550)",
                            .instead = "the size and the first tie point count"});
}

Result<void> find_transform(const TiffTags& tags, TiffPlace& place) {
  VT_ASSIGN(const std::vector<double> scale, tags.numbers(kModelPixelScale));
  VT_ASSIGN(const std::vector<double> tie, tags.numbers(kModelTiepoint));
  VT_ASSIGN(const std::vector<double> matrix, tags.numbers(kModelTransformation));
  const std::vector<TiePoint> points = tie_points(tie);
  if (place.keys.vertical && scale.size() >= 3 && scale[2] != 0.0 && !points.empty()) {
    const double offset = tie[5] - tie[2] * scale[2];
    if (scale[2] != 1.0) place.height_scale = scale[2];
    if (offset != 0.0) place.height_offset = offset;
  }
  const bool has_scale = scale.size() >= 2 && scale[0] != 0.0 && scale[1] != 0.0;
  if (has_scale && !points.empty()) {
    place_by_scale(scale, points, place);
  } else if (matrix.size() >= 8) {
    place.transform = geo::GeoTransform{
        .x0 = matrix[3], .x_column = matrix[0], .x_row = matrix[1], .y0 = matrix[7], .y_column = matrix[4], .y_row = matrix[5]};
  } else if (!points.empty()) {
    place_by_tie_points(points, place);
  } else if (has_scale) {
    place.problem = "a sample size (tag 33550) without a tie point (tag 33922) does not say where it lies";
  } else if (tags.has(kRpcCoefficients)) {
    place.problem =
        "it is placed by rational polynomial coefficients (tag 50844), which are not used; bring it onto a grid first, for example with "
        "gdalwarp -rpc in.tif new.tif";
  }
  if (!place.transform) return {};
  const bool finite = std::isfinite(place.transform->x0) && std::isfinite(place.transform->y0);
  if (!finite || !place.transform->inverse()) {
    place.problem = "the tags that place it (33550, 33922, 34264) put all samples on one line or nowhere";
    place.transform.reset();
  }
  return {};
}

}  // namespace

Result<TiffPlace> read_tiff_place(const TiffTags& tags) {
  geo::GeoKeyTags keys;
  VT_ASSIGN(const std::vector<double> directory, tags.numbers(kGeoKeyDirectory));
  for (const double value : directory)
    keys.directory.push_back(value >= 0.0 && value <= 65535.0 ? static_cast<std::uint16_t>(value) : std::uint16_t{0});
  VT_ASSIGN(keys.doubles, tags.numbers(kGeoDoubleParams));
  VT_ASSIGN(keys.ascii, tags.text(kGeoAsciiParams));
  TiffPlace place;
  place.keys = geo::crs_from_geo_keys(keys);
  VT_CHECK(find_transform(tags, place));
  if (place.transform && place.keys.pixel_is_point) {  // the tags name the centre of the first sample; we want its outer corner
    place.transform->x0 -= 0.5 * (place.transform->x_column + place.transform->x_row);
    place.transform->y0 -= 0.5 * (place.transform->y_column + place.transform->y_row);
  }
  return place;
}

}  // namespace vt::source
