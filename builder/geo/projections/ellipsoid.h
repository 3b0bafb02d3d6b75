// The figure of the Earth that a system counts on, and its radii of curvature. Plain values and arithmetic,
// any thread.
#pragma once

#include <numbers>
#include <string>

namespace vt::geo {

inline constexpr double kDegree = std::numbers::pi / 180.0;  // in radians

struct Ellipsoid {
  std::string name = "WGS 84";
  double semi_major_m = 6378137.0;
  double inverse_flattening = 298.257223563;  // 0 means a sphere

  [[nodiscard]] double flattening() const { return inverse_flattening == 0.0 ? 0.0 : 1.0 / inverse_flattening; }
  [[nodiscard]] double eccentricity_squared() const { return flattening() * (2.0 - flattening()); }
  // Finite, and not flatter than twice as wide as high: what comes from a file may be anything.
  [[nodiscard]] bool is_usable() const;
};

// Radii of curvature along the meridian and across it (Snyder, Map Projections - A Working Manual, 4-18 and
// 4-20).
struct Radii {
  double meridian_m;
  double transverse_m;
};
[[nodiscard]] Radii radii_at(const Ellipsoid& ellipsoid, double latitude_deg);

}  // namespace vt::geo
