#include "builder/pipeline/sources/source_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "builder/pipeline/sources/layer_grid.h"

namespace vt::pipeline {
namespace {

using source::RasterInfo;

constexpr double kFarthestLatitudeDeg = 90.0;
constexpr double kFarthestLongitudeDeg = 540.0;

// The box of the outermost sample centres, or `outset` samples farther out.
Bounds bounds_of_samples(const RasterInfo& info, const geo::GeoTransform& transform, double outset) {
  const double west = 0.5 - outset;
  const double east = static_cast<double>(info.width) - 0.5 + outset;
  const double north = 0.5 - outset;
  const double south = static_cast<double>(info.height) - 0.5 + outset;
  Bounds bounds;
  for (const Point2 corner : {Point2{west, north}, Point2{east, north}, Point2{west, south}, Point2{east, south}})
    bounds.add(transform.crs_from_raster(corner));
  return bounds;
}

// Half a sample of rounding is no reason to refuse a grid whose outermost samples lie on a pole.
double rounding_of(double step) { return 0.5 * std::abs(step); }

bool are_degrees(const RasterInfo& info, const geo::GeoTransform& transform) {
  const Bounds centres = bounds_of_samples(info, transform, 0.0);
  const double latitude = kFarthestLatitudeDeg + rounding_of(std::hypot(transform.y_column, transform.y_row));
  const double longitude = kFarthestLongitudeDeg + rounding_of(std::hypot(transform.x_column, transform.x_row));
  return centres.south >= -latitude && centres.north <= latitude && centres.west >= -longitude && centres.east <= longitude;
}

std::string extent_text(const Bounds& bounds) {
  return fmt::format("x from {:.10g} to {:.10g}, y from {:.10g} to {:.10g}", bounds.west, bounds.east, bounds.south, bounds.north);
}

// A GDAL command that brings the file into a CRS that is read.
std::string reproject_text(const SourceRequest& request, const RasterInfo& info) {
  const auto& wanted = request.stated_crs ? request.stated_crs : request.fallback_crs;
  const bool is_known = wanted && wanted->definition().epsg != 0;
  const bool is_geographic = info.declared_crs_text.find("geographic") != std::string::npos;
  const std::string target = is_known ? fmt::format("EPSG:{}", wanted->definition().epsg) : is_geographic ? "EPSG:4326" : "EPSG:326NN";
  return fmt::format("reproject it first, for example with gdalwarp -t_srs {} {} new.tif{}", target, request.path.filename().string(),
                     is_known || is_geographic ? "" : " (NN is the UTM zone where it lies; 327NN in the south)");
}

tl::unexpected<Error> unknown_crs(const SourceRequest& request, const RasterInfo& info) {
  const auto& given = request.stated_crs ? request.stated_crs : request.fallback_crs;
  const std::string not_overruled =
      given ? fmt::format("; it is not taken for {}, because a CRS that a file declares counts", given->text()) : "";
  return fail(
      ErrorCode::kUnsupported,
      fmt::format("{}: is in {}, which cannot be read: {}{}; {}; or, if the file is wrong about it, say what it is in with `source-crs` "
                  "EPSG:nnnn",
                  request.path.string(), info.declared_crs_text, info.crs_problem, not_overruled, reproject_text(request, info)));
}

tl::unexpected<Error> no_crs(const SourceRequest& request, const RasterInfo& info) {
  const bool may_be_degrees = !info.has_transform || are_degrees(info, info.transform);
  const std::string example = may_be_degrees
                                  ? "`crs` EPSG:4326"
                                  : fmt::format("`crs` EPSG:32633 for UTM zone 33 north: its coordinates ({}) are lengths and no degrees",
                                                extent_text(bounds_of_samples(info, info.transform, 0.5)));
  return fail(
      ErrorCode::kInvalidData,
      fmt::format("{}: no coordinate reference system in the file; give the one that it is in, for example {}{}, or `crs` pixel for a "
                  "picture without a place on the ground",
                  request.path.string(), example, info.has_transform ? "" : " `extent` WEST,SOUTH,EAST,NORTH"));
}

}  // namespace

Result<geo::Crs> crs_of_source(const SourceRequest& request, const RasterInfo& info) {
  if (request.crs) return *request.crs;
  if (info.declared_crs) {
    if (request.stated_crs && !request.stated_crs->same_coordinates(*info.declared_crs))
      return fail(
          ErrorCode::kInvalidData,
          fmt::format("{}: declares {}, but \"crs\" says that it is in {}; \"crs\" is for files that declare none: leave it out, or "
                      "overrule the file with \"source_crs\"",
                      request.path.string(), info.declared_crs->text(), request.stated_crs->text()));
    return *info.declared_crs;
  }
  if (!info.declared_crs_text.empty()) return unknown_crs(request, info);
  if (info.crs) return *info.crs;
  return no_crs(request, info);
}

Result<void> check_place(const OpenSource& source) {
  const RasterInfo& info = source.raster->info();
  if (source.crs.kind() == geo::CrsKind::kPixel) return {};
  const Bounds extent = bounds_of_samples(info, source.transform, 0.5);
  const std::string path = source.request.path.string();
  const char* const option = source.request.crs || info.declared_crs ? "`source-crs`" : "`crs`";
  if (source.crs.kind() == geo::CrsKind::kGeographic) {
    if (are_degrees(info, source.transform)) return {};
    const bool are_lengths = std::max({-extent.west, extent.east, -extent.south, extent.north}) > 2 * kFarthestLongitudeDeg;
    const bool are_exchanged = extent.west >= -kFarthestLatitudeDeg && extent.east <= kFarthestLatitudeDeg &&
                               extent.south >= -kFarthestLongitudeDeg && extent.north <= kFarthestLongitudeDeg;
    return fail(
        ErrorCode::kInvalidData,
        fmt::format("{}: {} are no longitudes and latitudes in degrees, as {} counts them{}", path, extent_text(extent), source.crs.text(),
                    are_lengths     ? fmt::format("; they look like metres: say which projected CRS they are in with {} EPSG:nnnn", option)
                    : are_exchanged ? std::string("; are x and y exchanged? x is the longitude")
                                    : std::string("; check the place that the file or `extent` gives")));
  }
  const Point2 centre{(extent.west + extent.east) / 2, (extent.south + extent.north) / 2};
  const auto lonlat = source.crs.unwrapped_lonlat_from_crs(centre);
  if (lonlat && std::abs(lonlat->x) <= kFarthestLongitudeDeg) return {};
  return fail(ErrorCode::kInvalidData,
              fmt::format("{}: {} lie nowhere on the Earth in {}; check their unit and the CRS, which {} EPSG:nnnn gives", path,
                          extent_text(extent), source.crs.text(), option));
}

bool looks_like_degrees(const OpenSource& source) {
  constexpr double kFinestStepM = 0.02;  // finer samples than these are rare, in degrees they are usual
  if (source.crs.kind() != geo::CrsKind::kProjected) return false;
  const Bounds extent = bounds_of_samples(source.raster->info(), source.transform, 0.5);
  return extent.west >= -360.0 && extent.east <= 360.0 && extent.south >= -kFarthestLatitudeDeg && extent.north <= kFarthestLatitudeDeg &&
         std::hypot(source.transform.x_column, source.transform.y_column) < kFinestStepM;
}

}  // namespace vt::pipeline
