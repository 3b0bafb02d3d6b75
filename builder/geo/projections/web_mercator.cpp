#include "builder/geo/projections/web_mercator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vt::geo {
namespace {

class SphericalMercator final : public Conversion {
 public:
  explicit SphericalMercator(const Ellipsoid& ellipsoid) : ellipsoid_(ellipsoid) {}

  std::optional<Point2> forward(Point2 lonlat_deg) const override {
    if (!(std::abs(lonlat_deg.y) < 90.0)) return std::nullopt;  // the poles are infinitely far away
    const double a = ellipsoid_.semi_major_m;
    return Point2{.x = a * lonlat_deg.x * kDegree, .y = a * std::asinh(std::tan(lonlat_deg.y * kDegree))};
  }
  std::optional<Point2> inverse(Point2 xy) const override {
    const double a = ellipsoid_.semi_major_m;
    return Point2{.x = xy.x / a / kDegree, .y = std::atan(std::sinh(xy.y / a)) / kDegree};
  }
  // Not quite conformal: the two differ by up to 0.7 %.
  Point2 ground_metres(Point2, Point2 lonlat_deg) const override {
    const Radii radii = radii_at(ellipsoid_, lonlat_deg.y);
    const double per_radian = std::max(0.0, std::cos(lonlat_deg.y * kDegree)) / ellipsoid_.semi_major_m;
    return {.x = radii.transverse_m * per_radian, .y = radii.meridian_m * per_radian};
  }
  std::optional<Turn> turn() const override { return Turn{.length = 2.0 * std::numbers::pi * ellipsoid_.semi_major_m}; }

 private:
  Ellipsoid ellipsoid_;
};

}  // namespace

std::unique_ptr<const Conversion> WebMercator::make(const Ellipsoid& ellipsoid) const {
  return std::make_unique<SphericalMercator>(ellipsoid);
}

}  // namespace vt::geo
