// Coordinate reference systems: what a source's x and y mean on the ground. The only room that sees GeographicLib.
// A Crs is a value; all const functions are safe from any thread. Longitudes and latitudes are degrees on the CRS's own datum: no datum
// shift is ever applied silently.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "store/result.h"
#include "store/vt_mapping.h"

namespace vt::geo {

struct Ellipsoid {
  std::string name = "WGS 84";
  double semi_major_m = 6378137.0;
  double inverse_flattening = 298.257223563;  // 0 means a sphere
};

enum class Projection {
  kPixel,               // no place on the Earth: x east, y north, in raster units
  kGeographic,          // x = longitude, y = latitude, degrees
  kTransverseMercator,  // UTM and every other Gauss-Krueger grid
  kWebMercator,         // EPSG:3857, spherical formulas on the ellipsoid's semi-major axis
};

// All parameters; lengths in metres, angles in degrees. Unused ones stay at their defaults.
struct CrsDefinition {
  Projection projection = Projection::kPixel;
  std::string name;
  int epsg = 0;        // 0: user-defined
  std::string datum;   // "WGS 84", "NAD83", "SIRGAS 2000", ...
  int datum_epsg = 0;  // the geographic CRS underneath: 4326, 4269, ...
  Ellipsoid ellipsoid;
  double latitude_of_origin_deg = 0.0;
  double central_meridian_deg = 0.0;
  double scale_factor = 1.0;
  double false_easting_m = 0.0;
  double false_northing_m = 0.0;
  double metres_per_unit = 1.0;  // of projected coordinates, for example 0.3048006... for US survey feet
};

class Crs {
 public:
  Crs();  // kPixel
  explicit Crs(CrsDefinition definition);
  // EPSG:4326 and other geographic codes of the common datums, UTM on WGS 84 / NAD 83 / ETRS89 / SIRGAS 2000 and others, EPSG:3857.
  // kUnsupported: the message names the code and how to give a supported one.
  [[nodiscard]] static Result<Crs> from_epsg(int code);
  // "EPSG:32633", "32633" or "pixel", as on the command line.
  [[nodiscard]] static Result<Crs> from_text(std::string_view text);
  [[nodiscard]] static Result<Crs> from_json(const nlohmann::json& json);  // inverse of to_json, exact
  [[nodiscard]] nlohmann::json to_json() const;

  [[nodiscard]] const CrsDefinition& definition() const;
  [[nodiscard]] std::string text() const;  // "EPSG:32633 (WGS 84 / UTM zone 33N)"
  // Same projection, parameters, ellipsoid and datum: coordinates agree without any transformation.
  [[nodiscard]] bool same_coordinates(const Crs& other) const;

  // Longitude x and latitude y in degrees from CRS coordinates and back. Not for kPixel (kUsage). kInvalidData where the projection has no
  // answer.
  [[nodiscard]] Result<Point2> lonlat_from_crs(Point2 crs) const;
  [[nodiscard]] Result<Point2> crs_from_lonlat(Point2 lonlat_deg) const;
  // As lonlat_from_crs, but longitudes do not jump where a raster crosses the antimeridian: they lie within 180 degrees of the central
  // meridian of a transverse Mercator, and are x itself, of any number of turns, where x is a longitude.
  [[nodiscard]] Result<Point2> unwrapped_lonlat_from_crs(Point2 crs) const;
  // CRS units to the east after which the same place comes again: 360 degrees, or the equator of Web Mercator. nullopt where none does.
  [[nodiscard]] std::optional<double> turn() const;

  // Ground metres per CRS unit along x and along y at a place, for ground sample distances.
  [[nodiscard]] Result<Point2> metres_per_unit_at(Point2 crs) const;

 private:
  struct Impl;  // the definition and the GeographicLib projection made from it
  std::shared_ptr<const Impl> impl_;
};

}  // namespace vt::geo
