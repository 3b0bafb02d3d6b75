#include "builder/geo/projections/ellipsoid.h"

#include <cmath>

namespace vt::geo {

bool Ellipsoid::is_usable() const {
  const double f = flattening();
  return std::isfinite(semi_major_m) && semi_major_m > 0.0 && std::isfinite(f) && f >= 0.0 && f < 0.5;
}

Radii radii_at(const Ellipsoid& ellipsoid, double latitude_deg) {
  const double e2 = ellipsoid.eccentricity_squared();
  const double sine = std::sin(latitude_deg * kDegree);
  const double w2 = 1.0 - e2 * sine * sine;
  return {.meridian_m = ellipsoid.semi_major_m * (1.0 - e2) / (w2 * std::sqrt(w2)), .transverse_m = ellipsoid.semi_major_m / std::sqrt(w2)};
}

}  // namespace vt::geo
