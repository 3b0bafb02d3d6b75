#include "builder/geo/projections/geographic.h"

#include <algorithm>
#include <cmath>

namespace vt::geo {
namespace {

class Degrees final : public Conversion {
 public:
  explicit Degrees(const Ellipsoid& ellipsoid) : ellipsoid_(ellipsoid) {}

  std::optional<Point2> forward(Point2 lonlat_deg) const override { return lonlat_deg; }
  std::optional<Point2> inverse(Point2 xy) const override { return xy; }
  Point2 ground_metres(Point2, Point2 lonlat_deg) const override {
    const Radii radii = radii_at(ellipsoid_, lonlat_deg.y);
    const double cosine = std::max(0.0, std::cos(lonlat_deg.y * kDegree));
    return {.x = radii.transverse_m * cosine * kDegree, .y = radii.meridian_m * kDegree};
  }
  std::optional<Turn> turn() const override { return Turn{.length = 360.0}; }

 private:
  Ellipsoid ellipsoid_;
};

}  // namespace

std::unique_ptr<const Conversion> Geographic::make(const Ellipsoid& ellipsoid) const { return std::make_unique<Degrees>(ellipsoid); }

}  // namespace vt::geo
