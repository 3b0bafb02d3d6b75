// Transverse Mercator (EPSG method 9807): UTM and every other Gauss-Krueger grid.
#pragma once

#include <memory>
#include <span>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct TransverseMercator {
  double latitude_of_origin_deg = 0.0;
  double central_meridian_deg = 0.0;
  double scale_factor = 1.0;
  double false_easting_m = 0.0;
  double false_northing_m = 0.0;

  static constexpr MethodInfo kInfo{.name = "transverse_mercator", .title = "transverse Mercator", .geo_key = 1};
  [[nodiscard]] static std::span<const Parameter<TransverseMercator>> parameters();
  [[nodiscard]] static TransverseMercator utm(int zone, bool is_south);
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid& ellipsoid) const;
};

}  // namespace vt::geo
