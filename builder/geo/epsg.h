// The part of the EPSG registry that we know by heart: geographic systems, UTM families, a table of other
// transverse Mercator grids, units, ellipsoids. Names and parameters only; the mathematics is in
// projections/. Constant data, any thread.
#pragma once

#include <optional>

#include "builder/geo/crs.h"

namespace vt::geo {

// A complete definition for a supported CRS code, geographic or projected.
[[nodiscard]] std::optional<CrsDefinition> definition_from_epsg(int code);
// The geographic definition whose geodetic datum (6xxx, as in GeogGeodeticDatumGeoKey) has this code.
[[nodiscard]] std::optional<CrsDefinition> geographic_from_datum(int datum_code);
[[nodiscard]] std::optional<Ellipsoid> ellipsoid_from_epsg(int code);
[[nodiscard]] std::optional<double> metres_from_length_unit(int code);  // 9001 metre, 9003 US survey foot, ...
[[nodiscard]] std::optional<double> degrees_from_angle_unit(int code);  // 9102 degree, 9101 radian, 9105 grad, ...

// The registry's code for a length unit of this size, 0 when it has none.
[[nodiscard]] int length_unit_code(double metres_per_unit);

}  // namespace vt::geo
