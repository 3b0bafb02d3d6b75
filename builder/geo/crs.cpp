#include "builder/geo/crs.h"

#include <fmt/format.h>

#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/TransverseMercatorExact.hpp>
#include <charconv>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "builder/geo/epsg.h"

namespace vt::geo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

constexpr const char* kWhatIsKnown =
    "known are longitudes and latitudes on the common datums (4326, 4269, 4258, ...), UTM zones (326xx, 327xx, 269xx, 258xx, ...) and "
    "other transverse Mercator grids, and 3857; a raster in another CRS has to be reprojected first, for example with gdalwarp -t_srs";

struct ProjectionName {
  Projection projection;
  const char* name;
};
constexpr ProjectionName kProjectionNames[] = {
    {Projection::kPixel, "pixel"},
    {Projection::kGeographic, "geographic"},
    {Projection::kTransverseMercator, "transverse_mercator"},
    {Projection::kWebMercator, "web_mercator"},
};

const char* projection_name(Projection projection) {
  for (const ProjectionName& row : kProjectionNames) {
    if (row.projection == projection) return row.name;
  }
  return "?";
}

double flattening_of(const Ellipsoid& ellipsoid) { return ellipsoid.inverse_flattening == 0.0 ? 0.0 : 1.0 / ellipsoid.inverse_flattening; }

bool is_usable(const Ellipsoid& ellipsoid) {
  const double flattening = flattening_of(ellipsoid);
  return std::isfinite(ellipsoid.semi_major_m) && ellipsoid.semi_major_m > 0.0 && std::isfinite(flattening) && flattening >= 0.0 &&
         flattening < 0.5;
}

// Radii of curvature along the meridian and across it (Snyder, Map Projections - A Working Manual, 4-18 and 4-20).
struct Radii {
  double meridian_m;
  double transverse_m;
};
Radii radii_at(const Ellipsoid& ellipsoid, double latitude_deg) {
  const double f = flattening_of(ellipsoid);
  const double e2 = f * (2.0 - f);
  const double sine = std::sin(latitude_deg * kDegree);
  const double w2 = 1.0 - e2 * sine * sine;
  return {.meridian_m = ellipsoid.semi_major_m * (1.0 - e2) / (w2 * std::sqrt(w2)), .transverse_m = ellipsoid.semi_major_m / std::sqrt(w2)};
}

// Gauss-Krueger on an ellipsoid: the 6th-order series within about 35 degrees of the central meridian (5 nm, by its header), the exact
// formulas in elliptic functions beyond. `eta` is the distance from the central meridian in semi-major axes.
class TransverseMercatorProjection {
 public:
  explicit TransverseMercatorProjection(const CrsDefinition& definition)
      : definition_(definition), series_(definition.ellipsoid.semi_major_m, flattening_of(definition.ellipsoid), definition.scale_factor) {
    if (definition.ellipsoid.inverse_flattening != 0.0) {
      exact_.emplace(definition.ellipsoid.semi_major_m, flattening_of(definition.ellipsoid), definition.scale_factor);
    }
    double x = 0.0;
    series_.Forward(0.0, definition.latitude_of_origin_deg, 0.0, x, origin_northing_m_);
  }

  // Easting and northing in metres with the false origin applied, nullopt beyond the projection's reach.
  std::optional<Point2> forward(Point2 lonlat_deg) const {
    double x = 0.0;
    double y = 0.0;
    const double offset_deg = std::remainder(lonlat_deg.x - definition_.central_meridian_deg, 360.0);
    if (exact_ && std::abs(offset_deg) > kSeriesReachDeg) {
      exact_->Forward(definition_.central_meridian_deg, lonlat_deg.y, lonlat_deg.x, x, y);
    } else {
      series_.Forward(definition_.central_meridian_deg, lonlat_deg.y, lonlat_deg.x, x, y);
    }
    if (!std::isfinite(x) || !std::isfinite(y) || std::abs(x) > reach_m(kMaximumEta)) return std::nullopt;
    return Point2{.x = x + definition_.false_easting_m, .y = y - origin_northing_m_ + definition_.false_northing_m};
  }

  struct Inverse {
    Point2 lonlat_deg;
    double scale;
  };
  std::optional<Inverse> inverse(Point2 metres) const {
    const double x = metres.x - definition_.false_easting_m;
    const double y = metres.y - definition_.false_northing_m + origin_northing_m_;
    // Beyond one turn of the meridian there is no such place.
    if (!(std::abs(x) <= reach_m(kMaximumEta)) || !(std::abs(y) <= reach_m(std::numbers::pi))) return std::nullopt;
    double latitude = 0.0;
    double longitude = 0.0;
    double convergence = 0.0;
    double scale = 0.0;
    if (exact_ && std::abs(x) > reach_m(kSeriesReachEta)) {
      exact_->Reverse(definition_.central_meridian_deg, x, y, latitude, longitude, convergence, scale);
    } else {
      series_.Reverse(definition_.central_meridian_deg, x, y, latitude, longitude, convergence, scale);
    }
    if (!std::isfinite(latitude) || !std::isfinite(longitude)) return std::nullopt;
    return Inverse{.lonlat_deg = {.x = longitude, .y = latitude}, .scale = scale};
  }

 private:
  static constexpr double kSeriesReachDeg = 30.0;
  static constexpr double kSeriesReachEta = 0.55;  // atanh(sin 30 degrees), where the equator meets the 30 degree meridian
  static constexpr double kMaximumEta = 2.6;       // 81 degrees from the meridian on the equator, a scale of 6.8

  double reach_m(double eta) const { return eta * definition_.ellipsoid.semi_major_m * definition_.scale_factor; }

  CrsDefinition definition_;
  GeographicLib::TransverseMercator series_;
  std::optional<GeographicLib::TransverseMercatorExact> exact_;
  double origin_northing_m_ = 0.0;
};

}  // namespace

struct Crs::Impl {
  CrsDefinition definition;
  std::optional<TransverseMercatorProjection> transverse_mercator;
  std::string problem;  // why no projection could be made of the parameters

  explicit Impl(CrsDefinition parameters) : definition(std::move(parameters)) {
    if (!is_usable(definition.ellipsoid)) {
      problem = fmt::format("ellipsoid \"{}\" with semi-major axis {} m and inverse flattening {} is impossible", definition.ellipsoid.name,
                            definition.ellipsoid.semi_major_m, definition.ellipsoid.inverse_flattening);
      return;
    }
    if (!std::isfinite(definition.metres_per_unit) || definition.metres_per_unit <= 0.0) {
      problem = fmt::format("a coordinate unit of {} m is impossible", definition.metres_per_unit);
      return;
    }
    if (definition.projection != Projection::kTransverseMercator) return;
    const bool finite = std::isfinite(definition.false_easting_m) && std::isfinite(definition.false_northing_m) &&
                        std::isfinite(definition.central_meridian_deg) && std::isfinite(definition.scale_factor);
    if (!finite || !(std::abs(definition.latitude_of_origin_deg) <= 90.0) || definition.scale_factor <= 0.0) {
      problem = fmt::format("transverse Mercator with latitude of origin {}, central meridian {}, scale factor {} is impossible",
                            definition.latitude_of_origin_deg, definition.central_meridian_deg, definition.scale_factor);
      return;
    }
    try {
      transverse_mercator.emplace(definition);
    } catch (const std::exception& refusal) {
      problem = refusal.what();
    }
  }
};

Crs::Crs()
    : Crs([] {
        CrsDefinition pixel;
        pixel.name = "pixel";
        return pixel;
      }()) {}
Crs::Crs(CrsDefinition definition) : impl_(std::make_shared<const Impl>(std::move(definition))) {}

Result<Crs> Crs::from_epsg(int code) {
  auto definition = definition_from_epsg(code);
  if (!definition)
    return fail(ErrorCode::kUnsupported, fmt::format("EPSG:{} is not a CRS that this program knows; {}", code, kWhatIsKnown));
  return Crs(*std::move(definition));
}

Result<Crs> Crs::from_text(std::string_view text) {
  if (text == "pixel") return Crs();
  std::string_view digits = text;
  if (digits.starts_with("EPSG:") || digits.starts_with("epsg:")) digits.remove_prefix(5);
  int code = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), code);
  if (digits.empty() || status != std::errc{} || end != digits.data() + digits.size()) {
    return fail(ErrorCode::kUsage, fmt::format("CRS \"{}\": wanted EPSG:nnnn or pixel", text));
  }
  return from_epsg(code);
}

nlohmann::json Crs::to_json() const {
  const CrsDefinition& d = impl_->definition;
  return {
      {"projection", projection_name(d.projection)},
      {"name", d.name},
      {"epsg", d.epsg},
      {"datum", d.datum},
      {"datum_epsg", d.datum_epsg},
      {"ellipsoid",
       {{"name", d.ellipsoid.name}, {"semi_major_m", d.ellipsoid.semi_major_m}, {"inverse_flattening", d.ellipsoid.inverse_flattening}}},
      {"latitude_of_origin_deg", d.latitude_of_origin_deg},
      {"central_meridian_deg", d.central_meridian_deg},
      {"scale_factor", d.scale_factor},
      {"false_easting_m", d.false_easting_m},
      {"false_northing_m", d.false_northing_m},
      {"metres_per_unit", d.metres_per_unit}};
}

Result<Crs> Crs::from_json(const nlohmann::json& json) {
  try {
    CrsDefinition d;
    const auto& projection = json.at("projection").get_ref<const std::string&>();
    bool known = false;
    for (const ProjectionName& row : kProjectionNames) {
      if (projection != row.name) continue;
      d.projection = row.projection;
      known = true;
    }
    if (!known) return fail(ErrorCode::kInvalidData, fmt::format("CRS: unknown projection \"{}\"", projection));
    json.at("name").get_to(d.name);
    json.at("epsg").get_to(d.epsg);
    json.at("datum").get_to(d.datum);
    json.at("datum_epsg").get_to(d.datum_epsg);
    const nlohmann::json& ellipsoid = json.at("ellipsoid");
    ellipsoid.at("name").get_to(d.ellipsoid.name);
    ellipsoid.at("semi_major_m").get_to(d.ellipsoid.semi_major_m);
    ellipsoid.at("inverse_flattening").get_to(d.ellipsoid.inverse_flattening);
    json.at("latitude_of_origin_deg").get_to(d.latitude_of_origin_deg);
    json.at("central_meridian_deg").get_to(d.central_meridian_deg);
    json.at("scale_factor").get_to(d.scale_factor);
    json.at("false_easting_m").get_to(d.false_easting_m);
    json.at("false_northing_m").get_to(d.false_northing_m);
    json.at("metres_per_unit").get_to(d.metres_per_unit);
    Crs crs(std::move(d));
    if (!crs.impl_->problem.empty()) return fail(ErrorCode::kInvalidData, "CRS: " + crs.impl_->problem);
    return crs;
  } catch (const nlohmann::json::exception& refusal) {
    return fail(ErrorCode::kInvalidData, fmt::format("CRS: {}", refusal.what()));
  }
}

const CrsDefinition& Crs::definition() const { return impl_->definition; }

std::string Crs::text() const {
  const CrsDefinition& d = impl_->definition;
  if (d.epsg != 0) return fmt::format("EPSG:{} ({})", d.epsg, d.name);
  return d.name.empty() ? projection_name(d.projection) : d.name;
}

bool Crs::same_coordinates(const Crs& other) const {
  const CrsDefinition& a = impl_->definition;
  const CrsDefinition& b = other.impl_->definition;
  if (a.projection != b.projection) return false;
  if (a.projection == Projection::kPixel) return true;
  // A datum is known by its code; one without a code by its name, which may be missing altogether.
  const bool same_datum = a.datum_epsg != 0 && b.datum_epsg != 0 ? a.datum_epsg == b.datum_epsg : a.datum == b.datum;
  const auto same_length = [](double p, double q) { return std::abs(p - q) <= 1e-6; };  // a micrometre
  const auto same_angle = [](double p, double q) { return std::abs(p - q) <= 1e-11; };  // a micrometre on the ground
  const auto same_ratio = [](double p, double q) { return std::abs(p - q) <= 1e-13 * std::abs(p); };
  if (!same_datum || !same_length(a.ellipsoid.semi_major_m, b.ellipsoid.semi_major_m) ||
      std::abs(flattening_of(a.ellipsoid) - flattening_of(b.ellipsoid)) > 1e-13) {
    return false;
  }
  if (a.projection == Projection::kGeographic) return true;
  if (!same_ratio(a.metres_per_unit, b.metres_per_unit)) return false;
  if (a.projection == Projection::kWebMercator) return true;
  return same_angle(a.latitude_of_origin_deg, b.latitude_of_origin_deg) && same_angle(a.central_meridian_deg, b.central_meridian_deg) &&
         same_ratio(a.scale_factor, b.scale_factor) && same_length(a.false_easting_m, b.false_easting_m) &&
         same_length(a.false_northing_m, b.false_northing_m);
}

Result<Point2> Crs::lonlat_from_crs(Point2 crs) const {
  const CrsDefinition& d = impl_->definition;
  const auto no_answer = [&] {
    return fail(ErrorCode::kInvalidData, fmt::format("{}: ({:.17g}, {:.17g}) is not a place on the Earth in this CRS{}{}", text(), crs.x,
                                                     crs.y, impl_->problem.empty() ? "" : ": ", impl_->problem));
  };
  if (d.projection == Projection::kPixel)
    return fail(ErrorCode::kUsage, "pixel coordinates have no longitude and latitude; give a CRS with --crs EPSG:nnnn");
  if (!impl_->problem.empty() || !std::isfinite(crs.x) || !std::isfinite(crs.y)) return no_answer();
  const Point2 metres{.x = crs.x * d.metres_per_unit, .y = crs.y * d.metres_per_unit};
  switch (d.projection) {
    case Projection::kPixel:
      break;
    case Projection::kGeographic:
      return crs;
    case Projection::kTransverseMercator: {
      const auto answer = impl_->transverse_mercator->inverse(metres);
      if (!answer) return no_answer();
      return answer->lonlat_deg;
    }
    case Projection::kWebMercator: {
      const double a = d.ellipsoid.semi_major_m;
      return Point2{.x = metres.x / a / kDegree, .y = std::atan(std::sinh(metres.y / a)) / kDegree};
    }
  }
  return no_answer();
}

Result<Point2> Crs::unwrapped_lonlat_from_crs(Point2 crs) const {
  VT_ASSIGN(Point2 lonlat_deg, lonlat_from_crs(crs));
  const CrsDefinition& d = impl_->definition;
  if (d.projection != Projection::kTransverseMercator) return lonlat_deg;
  // Whole turns only: a longitude that is near enough stays as it is, to the last bit.
  lonlat_deg.x -= 360.0 * std::round((lonlat_deg.x - d.central_meridian_deg) / 360.0);
  return lonlat_deg;
}

std::optional<double> Crs::turn() const {
  const CrsDefinition& d = impl_->definition;
  switch (d.projection) {
    case Projection::kGeographic:
      return 360.0;
    case Projection::kWebMercator:
      return 2.0 * std::numbers::pi * d.ellipsoid.semi_major_m / d.metres_per_unit;
    case Projection::kPixel:
    case Projection::kTransverseMercator:
      break;
  }
  return std::nullopt;
}

Result<Point2> Crs::crs_from_lonlat(Point2 lonlat_deg) const {
  const CrsDefinition& d = impl_->definition;
  const auto no_answer = [&] {
    return fail(ErrorCode::kInvalidData, fmt::format("{}: longitude {:.17g}, latitude {:.17g} is out of this CRS's reach{}{}", text(),
                                                     lonlat_deg.x, lonlat_deg.y, impl_->problem.empty() ? "" : ": ", impl_->problem));
  };
  if (d.projection == Projection::kPixel)
    return fail(ErrorCode::kUsage, "pixel coordinates have no longitude and latitude; give a CRS with --crs EPSG:nnnn");
  if (!impl_->problem.empty() || !std::isfinite(lonlat_deg.x) || !std::isfinite(lonlat_deg.y)) return no_answer();
  switch (d.projection) {
    case Projection::kPixel:
      break;
    case Projection::kGeographic:
      return lonlat_deg;
    case Projection::kTransverseMercator: {
      if (std::abs(lonlat_deg.y) > 90.0) return no_answer();
      const auto metres = impl_->transverse_mercator->forward(lonlat_deg);
      if (!metres) return no_answer();
      return Point2{.x = metres->x / d.metres_per_unit, .y = metres->y / d.metres_per_unit};
    }
    case Projection::kWebMercator: {
      if (!(std::abs(lonlat_deg.y) < 90.0)) return no_answer();  // the poles are infinitely far away
      const double a = d.ellipsoid.semi_major_m / d.metres_per_unit;
      return Point2{.x = a * lonlat_deg.x * kDegree, .y = a * std::asinh(std::tan(lonlat_deg.y * kDegree))};
    }
  }
  return no_answer();
}

Result<Point2> Crs::metres_per_unit_at(Point2 crs) const {
  const CrsDefinition& d = impl_->definition;
  VT_ASSIGN(const Point2 lonlat_deg, lonlat_from_crs(crs));
  const Radii radii = radii_at(d.ellipsoid, lonlat_deg.y);
  const double cosine = std::max(0.0, std::cos(lonlat_deg.y * kDegree));
  switch (d.projection) {
    case Projection::kPixel:
      break;
    case Projection::kGeographic:
      return Point2{.x = radii.transverse_m * cosine * kDegree, .y = radii.meridian_m * kDegree};
    case Projection::kTransverseMercator: {
      // Conformal: one scale in all directions.
      const auto answer = impl_->transverse_mercator->inverse({.x = crs.x * d.metres_per_unit, .y = crs.y * d.metres_per_unit});
      return Point2{.x = d.metres_per_unit / answer->scale, .y = d.metres_per_unit / answer->scale};
    }
    case Projection::kWebMercator: {
      // Spherical formulas over ellipsoidal latitudes: not quite conformal, so the two differ by up to 0.7 %.
      const double per_radian = cosine * d.metres_per_unit / d.ellipsoid.semi_major_m;
      return Point2{.x = radii.transverse_m * per_radian, .y = radii.meridian_m * per_radian};
    }
  }
  return fail(ErrorCode::kInternal, "unknown projection");
}

}  // namespace vt::geo
