// Coordinate reference systems: what a source's x and y mean on the ground. The mathematics is in
// projections/, one file a method. A Crs is a value; all const functions are safe from any thread. Longitudes
// and latitudes are degrees on the CRS's own datum: no datum shift is ever applied silently.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "builder/geo/projections/projection.h"
#include "store/result.h"
#include "store/vt_mapping.h"

namespace vt::geo {

// All that defines a system.
struct CrsDefinition {
  Projection projection;  // Pixel, where nothing else is said
  std::string name;
  int epsg = 0;        // 0: user-defined
  std::string datum;   // "WGS 84", "NAD83", "SIRGAS 2000", ...
  int datum_epsg = 0;  // the geographic CRS underneath: 4326, 4269, ...
  Ellipsoid ellipsoid;
  double metres_per_unit = 1.0;  // of projected coordinates, for example 0.3048006... for US survey feet
};

class Crs {
 public:
  Crs();  // pixel coordinates
  explicit Crs(CrsDefinition definition);
  // EPSG:4326 and other geographic codes of the common datums, UTM on WGS 84 / NAD 83 / ETRS89 / SIRGAS 2000
  // and others, EPSG:3857 and 3395. kUnsupported: the message names the code and how to give a supported one.
  [[nodiscard]] static Result<Crs> from_epsg(int code);
  // "EPSG:32633", "32633" or "pixel", as on the command line.
  [[nodiscard]] static Result<Crs> from_text(std::string_view text);
  // Inverse of to_json, exact. Keys but those of the projection's method and of the ellipsoid may be absent
  // and have defaults then.
  [[nodiscard]] static Result<Crs> from_json(const nlohmann::json& json);
  [[nodiscard]] nlohmann::json to_json() const;

  [[nodiscard]] const CrsDefinition& definition() const;
  [[nodiscard]] CrsKind kind() const;
  [[nodiscard]] std::string text() const;  // "EPSG:32633 (WGS 84 / UTM zone 33N)"
  // Same projection, parameters, ellipsoid and datum: coordinates agree without any transformation.
  [[nodiscard]] bool same_coordinates(const Crs& other) const;

  // Longitude x and latitude y in degrees from CRS coordinates and back. kUsage for pixel coordinates.
  // kInvalidData where the projection has no answer.
  [[nodiscard]] Result<Point2> lonlat_from_crs(Point2 crs) const;
  [[nodiscard]] Result<Point2> crs_from_lonlat(Point2 lonlat_deg) const;
  // As lonlat_from_crs, but longitudes do not jump where a raster crosses the antimeridian: they lie within
  // 180 degrees of the central one of near_side(), and where there is a turn() they follow x, any number of
  // turns.
  [[nodiscard]] Result<Point2> unwrapped_lonlat_from_crs(Point2 crs) const;
  // Where x goes round a circle of longitudes, in CRS units, as method.h has it: 360 degrees, or the equator
  // of Web Mercator.
  [[nodiscard]] std::optional<double> turn() const;
  [[nodiscard]] double x_of_greenwich() const;
  // The longitudes that belong together, where x goes round no circle.
  [[nodiscard]] std::optional<NearSide> near_side() const;

  // Ground metres per CRS unit along x and along y at a place, for ground sample distances.
  [[nodiscard]] Result<Point2> metres_per_unit_at(Point2 crs) const;

 private:
  struct Impl;  // the definition and the conversion made from it
  std::shared_ptr<const Impl> impl_;
};

}  // namespace vt::geo
