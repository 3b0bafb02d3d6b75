// Mercator on an ellipsoid, variants A and B (EPSG methods 9804 and 9805): the scale is given at the equator,
// or a parallel is that keeps its length.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct Mercator {
  double central_meridian_deg = 0.0;
  double latitude_of_origin_deg = 0.0;  // variant A has it, and has it 0
  double scale_factor = 1.0;            // variant A
  double standard_parallel_deg = 0.0;   // variant B
  double false_easting_m = 0.0;
  double false_northing_m = 0.0;

  static constexpr MethodInfo kInfo{.name = "mercator", .title = "Mercator", .geo_key = 7};
  [[nodiscard]] static std::span<const Parameter<Mercator>> parameters();
  [[nodiscard]] std::string problem() const;
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid& ellipsoid) const;
};

}  // namespace vt::geo
