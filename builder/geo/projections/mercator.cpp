#include "builder/geo/projections/mercator.h"

#include <GeographicLib/Math.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace vt::geo {
namespace {

// EPSG guidance note 7-2, 3.5.1; latitudes to conformal latitudes and back by GeographicLib, to the last
// bits.
class EllipsoidalMercator final : public Conversion {
 public:
  EllipsoidalMercator(const Mercator& parameters, const Ellipsoid& ellipsoid)
      : parameters_(parameters), ellipsoid_(ellipsoid), eccentricity_(std::sqrt(ellipsoid.eccentricity_squared())) {
    // The scale at the equator that gives the standard parallel its true length.
    const double latitude_deg = parameters.standard_parallel_deg;
    const double parallel_m = radii_at(ellipsoid, latitude_deg).transverse_m * std::cos(latitude_deg * kDegree);
    radius_m_ = parameters.scale_factor * (latitude_deg == 0.0 ? ellipsoid.semi_major_m : parallel_m);
  }

  std::optional<Point2> forward(Point2 lonlat_deg) const override {
    if (!(std::abs(lonlat_deg.y) < 90.0)) return std::nullopt;  // the poles are infinitely far away
    const double conformal = GeographicLib::Math::taupf(std::tan(lonlat_deg.y * kDegree), eccentricity_);
    return Point2{.x = radius_m_ * (lonlat_deg.x - parameters_.central_meridian_deg) * kDegree + parameters_.false_easting_m,
                  .y = radius_m_ * std::asinh(conformal) + parameters_.false_northing_m};
  }

  std::optional<Point2> inverse(Point2 xy) const override {
    const double conformal = std::sinh((xy.y - parameters_.false_northing_m) / radius_m_);
    const double latitude_deg = std::atan(GeographicLib::Math::tauf(conformal, eccentricity_)) / kDegree;
    if (!std::isfinite(latitude_deg)) return std::nullopt;
    return Point2{.x = (xy.x - parameters_.false_easting_m) / radius_m_ / kDegree + parameters_.central_meridian_deg, .y = latitude_deg};
  }

  // Conformal: one scale in all directions.
  Point2 ground_metres(Point2, Point2 lonlat_deg) const override {
    const double cosine = std::max(0.0, std::cos(lonlat_deg.y * kDegree));
    const double metres = radii_at(ellipsoid_, lonlat_deg.y).transverse_m * cosine / radius_m_;
    return {.x = metres, .y = metres};
  }

  std::optional<Turn> turn() const override {
    return Turn{.length = 2.0 * std::numbers::pi * radius_m_,
                .x_of_greenwich = parameters_.false_easting_m - radius_m_ * parameters_.central_meridian_deg * kDegree};
  }

 private:
  Mercator parameters_;
  Ellipsoid ellipsoid_;
  double eccentricity_;
  double radius_m_ = 0.0;  // of the cylinder
};

using enum GeoKey;

constexpr Parameter<Mercator> kParameters[] = {
    {.value = &Mercator::central_meridian_deg,
     .kind = ParameterKind::kLongitude,
     .json_key = "central_meridian_deg",
     .label = "central meridian",
     .geo_key = kNaturalOriginLongitude,
     .other_geo_keys = {kFalseOriginLongitude, kCenterLongitude},
     .is_required = true},
    {.value = &Mercator::latitude_of_origin_deg,
     .kind = ParameterKind::kLatitude,
     .json_key = "latitude_of_origin_deg",
     .label = "latitude of origin",
     .geo_key = kNaturalOriginLatitude,
     .other_geo_keys = {kFalseOriginLatitude, kCenterLatitude}},
    {.value = &Mercator::standard_parallel_deg,
     .kind = ParameterKind::kLatitude,
     .json_key = "standard_parallel_deg",
     .label = "standard parallel",
     .geo_key = kStandardParallel1,
     .is_omitted_at_default = true},
    {.value = &Mercator::false_easting_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_easting_m",
     .label = "false easting",
     .geo_key = kFalseEasting,
     .other_geo_keys = {kFalseOriginEasting, kCenterEasting}},
    {.value = &Mercator::false_northing_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_northing_m",
     .label = "false northing",
     .geo_key = kFalseNorthing,
     .other_geo_keys = {kFalseOriginNorthing, kCenterNorthing}},
    {.value = &Mercator::scale_factor,
     .kind = ParameterKind::kRatio,
     .json_key = "scale_factor",
     .label = "scale factor",
     .geo_key = kScaleAtNaturalOrigin,
     .other_geo_keys = {kScaleAtCenter},
     .is_omitted_at_default = true},
};

}  // namespace

std::span<const Parameter<Mercator>> Mercator::parameters() { return kParameters; }

std::string Mercator::problem() const {
  if (latitude_of_origin_deg != 0.0) return "a Mercator whose origin is not on the equator is not known";
  if (std::abs(standard_parallel_deg) == 90.0) return "a Mercator whose standard parallel is a pole is impossible";
  if (standard_parallel_deg != 0.0 && scale_factor != 1.0) return "a Mercator has a scale factor or a standard parallel, not both";
  return {};
}

std::unique_ptr<const Conversion> Mercator::make(const Ellipsoid& ellipsoid) const {
  return std::make_unique<EllipsoidalMercator>(*this, ellipsoid);
}

}  // namespace vt::geo
