#include "builder/geo/projections/cylindrical_equal_area.h"

#include <GeographicLib/AlbersEqualArea.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace vt::geo {
namespace {

// GeographicLib's cone of two parallels that are each other's mirror image is a cylinder. x is counted here,
// for any number of turns.
class EqualAreaCylinder final : public Conversion {
 public:
  EqualAreaCylinder(const CylindricalEqualArea& parameters, const Ellipsoid& ellipsoid)
      : parameters_(parameters),
        ellipsoid_(ellipsoid),
        radius_m_(radii_at(ellipsoid, parameters.standard_parallel_deg).transverse_m *
                  std::cos(parameters.standard_parallel_deg * kDegree)),
        cone_(ellipsoid.semi_major_m, ellipsoid.flattening(), parameters.standard_parallel_deg, -parameters.standard_parallel_deg, 1.0) {
    double x = 0.0;
    cone_.Forward(0.0, 90.0, 0.0, x, pole_y_);
  }

  std::optional<Point2> forward(Point2 lonlat_deg) const override {
    if (!(std::abs(lonlat_deg.y) <= 90.0)) return std::nullopt;
    double x = 0.0;
    double y = 0.0;
    cone_.Forward(0.0, lonlat_deg.y, 0.0, x, y);
    return Point2{.x = radius_m_ * (lonlat_deg.x - parameters_.central_meridian_deg) * kDegree + parameters_.false_easting_m,
                  .y = y + parameters_.false_northing_m};
  }

  std::optional<Point2> inverse(Point2 xy) const override {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
    const double y = xy.y - parameters_.false_northing_m;
    cone_.Reverse(0.0, 0.0, y, latitude_deg, longitude_deg);
    // The cone takes what lies beyond a pole for the pole.
    constexpr double kRounding = 1e-12;
    if (!std::isfinite(latitude_deg) || std::abs(y) > pole_y_ * (1.0 + kRounding)) return std::nullopt;
    return Point2{.x = (xy.x - parameters_.false_easting_m) / radius_m_ / kDegree + parameters_.central_meridian_deg, .y = latitude_deg};
  }

  // What is stretched along a parallel is pressed together along the meridian.
  Point2 ground_metres(Point2, Point2 lonlat_deg) const override {
    const double cosine = std::max(0.0, std::cos(lonlat_deg.y * kDegree));
    const double along_parallel = radii_at(ellipsoid_, lonlat_deg.y).transverse_m * cosine / radius_m_;
    return {.x = along_parallel, .y = 1.0 / along_parallel};
  }

  std::optional<Turn> turn() const override {
    return Turn{.length = 2.0 * std::numbers::pi * radius_m_,
                .x_of_greenwich = parameters_.false_easting_m - radius_m_ * parameters_.central_meridian_deg * kDegree};
  }

 private:
  CylindricalEqualArea parameters_;
  Ellipsoid ellipsoid_;
  double radius_m_;  // of the cylinder
  GeographicLib::AlbersEqualArea cone_;
  double pole_y_ = 0.0;
};

using enum GeoKey;

constexpr Parameter<CylindricalEqualArea> kParameters[] = {
    {.value = &CylindricalEqualArea::central_meridian_deg,
     .kind = ParameterKind::kLongitude,
     .json_key = "central_meridian_deg",
     .label = "central meridian",
     .geo_key = kNaturalOriginLongitude,
     .other_geo_keys = {kCenterLongitude, kFalseOriginLongitude},
     .is_required = true},
    {.value = &CylindricalEqualArea::standard_parallel_deg,
     .kind = ParameterKind::kLatitude,
     .json_key = "standard_parallel_deg",
     .label = "standard parallel",
     .geo_key = kStandardParallel1},
    {.value = &CylindricalEqualArea::false_easting_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_easting_m",
     .label = "false easting",
     .geo_key = kFalseEasting,
     .other_geo_keys = {kFalseOriginEasting, kCenterEasting}},
    {.value = &CylindricalEqualArea::false_northing_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_northing_m",
     .label = "false northing",
     .geo_key = kFalseNorthing,
     .other_geo_keys = {kFalseOriginNorthing, kCenterNorthing}},
};

}  // namespace

std::span<const Parameter<CylindricalEqualArea>> CylindricalEqualArea::parameters() { return kParameters; }

std::string CylindricalEqualArea::problem() const {
  return std::abs(standard_parallel_deg) == 90.0 ? "a cylindrical equal area projection whose standard parallel is a pole is impossible"
                                                 : "";
}

std::unique_ptr<const Conversion> CylindricalEqualArea::make(const Ellipsoid& ellipsoid) const {
  return std::make_unique<EqualAreaCylinder>(*this, ellipsoid);
}

}  // namespace vt::geo
