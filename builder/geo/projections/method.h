// What a projection method tells the rest of the folder of itself, so that nobody needs a list of methods:
// what it is called, its parameters, and the conversion that is made of them. README.md says how a method is
// added.
#pragma once

#include <array>
#include <optional>

#include "builder/geo/projections/ellipsoid.h"
#include "builder/geo/projections/geo_key.h"
#include "store/vt_mapping.h"

namespace vt::geo {

enum class CrsKind {
  kPixel,       // no place on the Earth: x east, y north, in raster units
  kGeographic,  // x = longitude, y = latitude, degrees
  kProjected,   // lengths on a map
};

// The row of a method.
struct MethodInfo {
  const char* name;   // in JSON, as "transverse_mercator": never changed, stores keep it
  const char* title;  // in messages, as "transverse Mercator"
  CrsKind kind = CrsKind::kProjected;
  int geo_key = 0;    // its number in GeoKey 3075; 0: GeoTIFF has none
  int only_epsg = 0;  // the code of its one system, where the registry has a single one and GeoKeys can name it in no other way
};

// The kind of a parameter gives its unit, the range in which it makes sense, and the difference that counts
// for nothing.
enum class ParameterKind {
  kLongitude,  // degrees
  kLatitude,   // degrees, from -90 to 90
  kLength,     // metres
  kRatio,      // greater than 0
};

// One parameter of a method: where it is kept, and where files keep it. All of them have a default, which is
// what an absent key means.
template <class Method>
struct Parameter {
  double Method::*value;
  ParameterKind kind;
  const char* json_key;                       // as "central_meridian_deg": never changed; methods share keys where they share meanings
  const char* label;                          // in messages, as "central meridian"
  GeoKey geo_key;                             // what is written; in the files' own units
  std::array<GeoKey, 2> other_geo_keys = {};  // what some programs write in its place; the first that is there counts
  bool is_required = false;                   // in GeoKeys
  bool is_omitted_at_default = false;         // in GeoKeys: its presence would mean another variant of the method
};

// Where longitude is a circle that x alone goes round: x = x_of_greenwich + length * longitude / 360, for any
// number of turns.
struct Turn {
  double length = 360.0;
  double x_of_greenwich = 0.0;
};

// Where it is none: the longitudes that belong together lie around a central one. Edges of an area enclose
// what lies between them when they lie less than `reach_deg` from it.
struct NearSide {
  double central_deg = 0.0;
  double reach_deg = 180.0;
};

// A method with parameters and an ellipsoid, ready to convert coordinates. Lengths are metres, whatever the
// unit of the CRS; of geographic systems x and y are degrees. Immutable: any number of threads.
class Conversion {
 public:
  virtual ~Conversion() = default;
  // Numbers are finite; nullopt where the projection has no answer.
  [[nodiscard]] virtual std::optional<Point2> forward(Point2 lonlat_deg) const = 0;
  [[nodiscard]] virtual std::optional<Point2> inverse(Point2 xy) const = 0;
  // Ground metres per unit of x and of y at a place for which inverse(xy) gave `lonlat_deg`.
  [[nodiscard]] virtual Point2 ground_metres(Point2 xy, Point2 lonlat_deg) const = 0;
  // One of the two.
  [[nodiscard]] virtual std::optional<Turn> turn() const { return std::nullopt; }
  [[nodiscard]] virtual std::optional<NearSide> near_side() const { return std::nullopt; }
};

}  // namespace vt::geo
