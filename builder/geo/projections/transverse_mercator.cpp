#include "builder/geo/projections/transverse_mercator.h"

#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/TransverseMercatorExact.hpp>
#include <cmath>
#include <numbers>
#include <optional>

namespace vt::geo {
namespace {

// Gauss-Krueger on an ellipsoid: the 6th-order series within about 35 degrees of the central meridian (5 nm,
// by its header), the exact formulas in elliptic functions beyond. `eta` is the distance from the central
// meridian in semi-major axes.
class GaussKrueger final : public Conversion {
 public:
  GaussKrueger(const TransverseMercator& parameters, const Ellipsoid& ellipsoid)
      : parameters_(parameters),
        semi_major_m_(ellipsoid.semi_major_m),
        series_(ellipsoid.semi_major_m, ellipsoid.flattening(), parameters.scale_factor) {
    if (ellipsoid.inverse_flattening != 0.0) exact_.emplace(ellipsoid.semi_major_m, ellipsoid.flattening(), parameters.scale_factor);
    double x = 0.0;
    series_.Forward(0.0, parameters.latitude_of_origin_deg, 0.0, x, origin_northing_m_);
  }

  std::optional<Point2> forward(Point2 lonlat_deg) const override {
    if (std::abs(lonlat_deg.y) > 90.0) return std::nullopt;
    double x = 0.0;
    double y = 0.0;
    const double offset_deg = std::remainder(lonlat_deg.x - parameters_.central_meridian_deg, 360.0);
    if (exact_ && std::abs(offset_deg) > kSeriesReachDeg) {
      exact_->Forward(parameters_.central_meridian_deg, lonlat_deg.y, lonlat_deg.x, x, y);
    } else {
      series_.Forward(parameters_.central_meridian_deg, lonlat_deg.y, lonlat_deg.x, x, y);
    }
    if (!std::isfinite(x) || !std::isfinite(y) || std::abs(x) > reach_m(kMaximumEta)) return std::nullopt;
    return Point2{.x = x + parameters_.false_easting_m, .y = y - origin_northing_m_ + parameters_.false_northing_m};
  }

  std::optional<Point2> inverse(Point2 xy) const override {
    const auto place = place_of(xy);
    if (!place) return std::nullopt;
    return place->lonlat_deg;
  }

  // Conformal: one scale in all directions.
  Point2 ground_metres(Point2 xy, Point2) const override {
    const auto place = place_of(xy);
    const double metres = place ? 1.0 / place->scale : 1.0;
    return {.x = metres, .y = metres};
  }

  // There are answers for the far side of the Earth, too, but edges that reach there do not enclose what lies
  // between them.
  std::optional<NearSide> near_side() const override {
    return NearSide{.central_deg = parameters_.central_meridian_deg, .reach_deg = 90.0};
  }

 private:
  static constexpr double kSeriesReachDeg = 30.0;
  static constexpr double kSeriesReachEta = 0.55;  // atanh(sin 30 degrees), where the equator meets the 30 degree meridian
  static constexpr double kMaximumEta = 2.6;       // 81 degrees from the meridian on the equator, a scale of 6.8

  struct Place {
    Point2 lonlat_deg;
    double scale;
  };
  std::optional<Place> place_of(Point2 xy) const {
    const double x = xy.x - parameters_.false_easting_m;
    const double y = xy.y - parameters_.false_northing_m + origin_northing_m_;
    // Beyond one turn of the meridian there is no such place.
    if (!(std::abs(x) <= reach_m(kMaximumEta)) || !(std::abs(y) <= reach_m(std::numbers::pi))) return std::nullopt;
    double latitude = 0.0;
    double longitude = 0.0;
    double convergence = 0.0;
    double scale = 0.0;
    if (exact_ && std::abs(x) > reach_m(kSeriesReachEta)) {
      exact_->Reverse(parameters_.central_meridian_deg, x, y, latitude, longitude, convergence, scale);
    } else {
      series_.Reverse(parameters_.central_meridian_deg, x, y, latitude, longitude, convergence, scale);
    }
    if (!std::isfinite(latitude) || !std::isfinite(longitude)) return std::nullopt;
    return Place{.lonlat_deg = {.x = longitude, .y = latitude}, .scale = scale};
  }
  double reach_m(double eta) const { return eta * semi_major_m_ * parameters_.scale_factor; }

  TransverseMercator parameters_;
  double semi_major_m_;
  GeographicLib::TransverseMercator series_;
  std::optional<GeographicLib::TransverseMercatorExact> exact_;
  double origin_northing_m_ = 0.0;
};

using enum GeoKey;

constexpr Parameter<TransverseMercator> kParameters[] = {
    {.value = &TransverseMercator::central_meridian_deg,
     .kind = ParameterKind::kLongitude,
     .json_key = "central_meridian_deg",
     .label = "central meridian",
     .geo_key = kNaturalOriginLongitude,
     .other_geo_keys = {kFalseOriginLongitude, kCenterLongitude},
     .is_required = true},
    {.value = &TransverseMercator::latitude_of_origin_deg,
     .kind = ParameterKind::kLatitude,
     .json_key = "latitude_of_origin_deg",
     .label = "latitude of origin",
     .geo_key = kNaturalOriginLatitude,
     .other_geo_keys = {kFalseOriginLatitude, kCenterLatitude}},
    {.value = &TransverseMercator::false_easting_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_easting_m",
     .label = "false easting",
     .geo_key = kFalseEasting,
     .other_geo_keys = {kFalseOriginEasting, kCenterEasting}},
    {.value = &TransverseMercator::false_northing_m,
     .kind = ParameterKind::kLength,
     .json_key = "false_northing_m",
     .label = "false northing",
     .geo_key = kFalseNorthing,
     .other_geo_keys = {kFalseOriginNorthing, kCenterNorthing}},
    {.value = &TransverseMercator::scale_factor,
     .kind = ParameterKind::kRatio,
     .json_key = "scale_factor",
     .label = "scale factor",
     .geo_key = kScaleAtNaturalOrigin,
     .other_geo_keys = {kScaleAtCenter}},
};

}  // namespace

std::span<const Parameter<TransverseMercator>> TransverseMercator::parameters() { return kParameters; }

TransverseMercator TransverseMercator::utm(int zone, bool is_south) {
  return {.latitude_of_origin_deg = 0.0,
          .central_meridian_deg = 6.0 * zone - 183.0,
          .scale_factor = 0.9996,
          .false_easting_m = 500000.0,
          .false_northing_m = is_south ? 10000000.0 : 0.0};
}

std::unique_ptr<const Conversion> TransverseMercator::make(const Ellipsoid& ellipsoid) const {
  return std::make_unique<GaussKrueger>(*this, ellipsoid);
}

}  // namespace vt::geo
