#include "builder/geo/crs.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "builder/geo/epsg.h"

namespace vt::geo {
namespace {

constexpr const char* kWhatIsKnown =
    "known are longitudes and latitudes on the common datums (4326, 4269, 4258, ...), UTM zones (326xx, 327xx, 269xx, 258xx, ...) and "
    "other transverse Mercator grids, 3857 and 3395; a raster in another CRS has to be reprojected first, for example with gdalwarp -t_srs";

constexpr const char* kNoPlace = "pixel coordinates have no longitude and latitude; give a CRS with `crs` EPSG:nnnn";

// Parameters that stores keep for every system: older programs do not open a store without them. Others are
// kept by the methods that have them.
constexpr std::pair<const char*, double> kParametersOfAll[] = {{"latitude_of_origin_deg", 0.0},
                                                               {"central_meridian_deg", 0.0},
                                                               {"scale_factor", 1.0},
                                                               {"false_easting_m", 0.0},
                                                               {"false_northing_m", 0.0}};

template <class T>
void read_optional(const nlohmann::json& json, const char* key, T& value) {
  if (const auto found = json.find(key); found != json.end()) found->get_to(value);
}

// The value in `json` that `known` has no name for; empty when there is none. Words are passed over; all else
// is or holds numbers or choices, which may move every place.
std::string unknown_value(const nlohmann::json& json, const nlohmann::json& known) {
  for (const auto& [key, value] : json.items())
    if (!value.is_string() && !known.contains(key)) return key;
  return "";
}

bool is_same_datum(const CrsDefinition& a, const CrsDefinition& b) {
  // A datum is known by its code; one without a code by its name, which may be missing altogether.
  const bool same_name = a.datum_epsg != 0 && b.datum_epsg != 0 ? a.datum_epsg == b.datum_epsg : a.datum == b.datum;
  constexpr double kMicrometre = 1e-6;
  return same_name && std::abs(a.ellipsoid.semi_major_m - b.ellipsoid.semi_major_m) <= kMicrometre &&
         std::abs(a.ellipsoid.flattening() - b.ellipsoid.flattening()) <= 1e-13;
}

}  // namespace

struct Crs::Impl {
  CrsDefinition definition;
  std::unique_ptr<const Conversion> conversion;  // none for pixel coordinates, and where there is a problem
  std::string problem;                           // why no conversion could be made of the parameters

  explicit Impl(CrsDefinition parameters) : definition(std::move(parameters)) {
    const Ellipsoid& ellipsoid = definition.ellipsoid;
    if (!ellipsoid.is_usable()) {
      problem = fmt::format("ellipsoid \"{}\" with semi-major axis {} m and inverse flattening {} is impossible", ellipsoid.name,
                            ellipsoid.semi_major_m, ellipsoid.inverse_flattening);
      return;
    }
    if (!std::isfinite(definition.metres_per_unit) || definition.metres_per_unit <= 0.0) {
      problem = fmt::format("a coordinate unit of {} m is impossible", definition.metres_per_unit);
      return;
    }
    problem = problem_of(definition.projection);
    if (!problem.empty()) return;
    try {
      conversion = conversion_of(definition.projection, ellipsoid);
    } catch (const std::exception& refusal) {
      problem = refusal.what();
    }
  }

  [[nodiscard]] CrsKind kind() const { return info_of(definition.projection).kind; }
  // Lengths of the conversion in one unit of the CRS; degrees have no other unit.
  [[nodiscard]] double unit() const { return kind() == CrsKind::kProjected ? definition.metres_per_unit : 1.0; }
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
  nlohmann::json json = {
      {"projection", info_of(d.projection).name},
      {"name", d.name},
      {"epsg", d.epsg},
      {"datum", d.datum},
      {"datum_epsg", d.datum_epsg},
      {"ellipsoid",
       {{"name", d.ellipsoid.name}, {"semi_major_m", d.ellipsoid.semi_major_m}, {"inverse_flattening", d.ellipsoid.inverse_flattening}}},
      {"metres_per_unit", d.metres_per_unit}};
  for (const auto& [key, unused] : kParametersOfAll) json[key] = unused;
  write_parameters(d.projection, json);
  return json;
}

Result<Crs> Crs::from_json(const nlohmann::json& json) {
  try {
    CrsDefinition d;
    const auto& name = json.at("projection").get_ref<const std::string&>();
    auto projection = projection_named(name);
    if (!projection) return fail(ErrorCode::kInvalidData, fmt::format("CRS: unknown projection \"{}\"", name));
    d.projection = *std::move(projection);
    read_parameters(json, d.projection);
    const nlohmann::json& ellipsoid = json.at("ellipsoid");
    read_optional(ellipsoid, "name", d.ellipsoid.name);
    ellipsoid.at("semi_major_m").get_to(d.ellipsoid.semi_major_m);
    ellipsoid.at("inverse_flattening").get_to(d.ellipsoid.inverse_flattening);
    read_optional(json, "name", d.name);
    read_optional(json, "epsg", d.epsg);
    read_optional(json, "datum", d.datum);
    read_optional(json, "datum_epsg", d.datum_epsg);
    read_optional(json, "metres_per_unit", d.metres_per_unit);
    Crs crs(std::move(d));
    if (!crs.impl_->problem.empty()) return fail(ErrorCode::kInvalidData, "CRS: " + crs.impl_->problem);
    const nlohmann::json known = crs.to_json();
    for (const auto& [given, names] : {std::pair(&json, &known), std::pair(&ellipsoid, &known["ellipsoid"])})
      if (const std::string key = unknown_value(*given, *names); !key.empty())
        return fail(ErrorCode::kInvalidData,
                    fmt::format("CRS: a {} with a parameter \"{}\" is not known here; a newer program may have written it", name, key));
    return crs;
  } catch (const nlohmann::json::exception& refusal) {
    return fail(ErrorCode::kInvalidData, fmt::format("CRS: {}", refusal.what()));
  }
}

const CrsDefinition& Crs::definition() const { return impl_->definition; }
CrsKind Crs::kind() const { return impl_->kind(); }

std::string Crs::text() const {
  const CrsDefinition& d = impl_->definition;
  if (d.epsg != 0) return fmt::format("EPSG:{} ({})", d.epsg, d.name);
  return d.name.empty() ? info_of(d.projection).name : d.name;
}

bool Crs::same_coordinates(const Crs& other) const {
  const CrsDefinition& a = impl_->definition;
  const CrsDefinition& b = other.impl_->definition;
  if (!is_same(a.projection, b.projection)) return false;
  switch (kind()) {
    case CrsKind::kPixel:
      return true;
    case CrsKind::kGeographic:
      return is_same_datum(a, b);
    case CrsKind::kProjected:
      return is_same_datum(a, b) && std::abs(a.metres_per_unit - b.metres_per_unit) <= 1e-13 * std::abs(a.metres_per_unit);
  }
  return false;
}

Result<Point2> Crs::lonlat_from_crs(Point2 crs) const {
  if (kind() == CrsKind::kPixel) return fail(ErrorCode::kUsage, kNoPlace);
  if (impl_->conversion && std::isfinite(crs.x) && std::isfinite(crs.y))
    if (const auto lonlat_deg = impl_->conversion->inverse({.x = crs.x * impl_->unit(), .y = crs.y * impl_->unit()})) return *lonlat_deg;
  return fail(ErrorCode::kInvalidData, fmt::format("{}: ({:.17g}, {:.17g}) is not a place on the Earth in this CRS{}{}", text(), crs.x,
                                                   crs.y, impl_->problem.empty() ? "" : ": ", impl_->problem));
}

Result<Point2> Crs::unwrapped_lonlat_from_crs(Point2 crs) const {
  VT_ASSIGN(Point2 lonlat_deg, lonlat_from_crs(crs));
  // Whole turns only: a longitude that is near enough stays as it is, to the last bit.
  if (const auto near = near_side()) lonlat_deg.x -= 360.0 * std::round((lonlat_deg.x - near->central_deg) / 360.0);
  return lonlat_deg;
}

std::optional<double> Crs::turn() const {
  const auto turn = impl_->conversion ? impl_->conversion->turn() : std::nullopt;
  return turn ? std::optional(turn->length / impl_->unit()) : std::nullopt;
}

double Crs::x_of_greenwich() const {
  const auto turn = impl_->conversion ? impl_->conversion->turn() : std::nullopt;
  return turn ? turn->x_of_greenwich / impl_->unit() : 0.0;
}

std::optional<NearSide> Crs::near_side() const { return impl_->conversion ? impl_->conversion->near_side() : std::nullopt; }

Result<Point2> Crs::crs_from_lonlat(Point2 lonlat_deg) const {
  if (kind() == CrsKind::kPixel) return fail(ErrorCode::kUsage, kNoPlace);
  if (impl_->conversion && std::isfinite(lonlat_deg.x) && std::isfinite(lonlat_deg.y))
    if (const auto xy = impl_->conversion->forward(lonlat_deg)) return Point2{.x = xy->x / impl_->unit(), .y = xy->y / impl_->unit()};
  return fail(ErrorCode::kInvalidData, fmt::format("{}: longitude {:.17g}, latitude {:.17g} is out of this CRS's reach{}{}", text(),
                                                   lonlat_deg.x, lonlat_deg.y, impl_->problem.empty() ? "" : ": ", impl_->problem));
}

Result<Point2> Crs::metres_per_unit_at(Point2 crs) const {
  VT_ASSIGN(const Point2 lonlat_deg, lonlat_from_crs(crs));
  const double unit = impl_->unit();
  const Point2 metres = impl_->conversion->ground_metres({.x = crs.x * unit, .y = crs.y * unit}, lonlat_deg);
  return Point2{.x = unit * metres.x, .y = unit * metres.y};
}

}  // namespace vt::geo
