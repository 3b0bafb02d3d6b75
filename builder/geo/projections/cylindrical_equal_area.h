// Lambert's cylindrical equal area projection on an ellipsoid (EPSG method 9835), as of the global EASE
// grids.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct CylindricalEqualArea {
  double central_meridian_deg = 0.0;
  double standard_parallel_deg = 0.0;
  double false_easting_m = 0.0;
  double false_northing_m = 0.0;

  static constexpr MethodInfo kInfo{.name = "cylindrical_equal_area", .title = "cylindrical equal area", .geo_key = 28};
  [[nodiscard]] static std::span<const Parameter<CylindricalEqualArea>> parameters();
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid& ellipsoid) const;
};

}  // namespace vt::geo
