#include "builder/geo/geo_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string_view>

#include "builder/geo/epsg.h"
#include "store/result.h"

namespace vt::geo {
namespace {

using enum GeoKey;

constexpr int kUserDefined = 32767;
constexpr int kModelProjected = 1;
constexpr int kModelGeographic = 2;
constexpr int kModelGeocentric = 3;
constexpr int kPixelIsPoint = 2;
constexpr int kGreenwich = 8901;
constexpr std::uint16_t kDoubleTag = 34736;
constexpr std::uint16_t kAsciiTag = 34737;
constexpr const char* kPixelCitation = "pixel coordinates";

// GeoKey 3075, by number (OGC 19-008r4, projection methods of GeoTIFF 1.0).
constexpr std::array<std::string_view, 29> kMethodNames = {"",
                                                           "transverse Mercator",
                                                           "modified transverse Mercator of Alaska",
                                                           "oblique Mercator",
                                                           "oblique Mercator (Laborde)",
                                                           "oblique Mercator (Rosenmund)",
                                                           "spherical oblique Mercator",
                                                           "Mercator",
                                                           "Lambert conformal conic with two parallels",
                                                           "Lambert conformal conic with one parallel",
                                                           "Lambert azimuthal equal area",
                                                           "Albers equal area",
                                                           "azimuthal equidistant",
                                                           "equidistant conic",
                                                           "stereographic",
                                                           "polar stereographic",
                                                           "oblique stereographic",
                                                           "equirectangular",
                                                           "Cassini-Soldner",
                                                           "gnomonic",
                                                           "Miller cylindrical",
                                                           "orthographic",
                                                           "polyconic",
                                                           "Robinson",
                                                           "sinusoidal",
                                                           "van der Grinten",
                                                           "New Zealand map grid",
                                                           "transverse Mercator oriented south",
                                                           "cylindrical equal area"};

// Free text from a file goes into messages and JSON: printable ASCII only.
std::string cleaned(std::string_view text) {
  std::string result(text.substr(0, 200));
  for (char& c : result) {
    if (c < ' ' || c > '~') c = c == '\n' || c == '\t' ? ' ' : '?';
  }
  while (!result.empty() && (result.back() == ' ' || result.back() == '|' || result.back() == '?')) result.pop_back();
  return result;
}

// "GCS Name = A|Datum = B|Ellipsoid = C": the value of one field, empty when the text is not of that kind.
std::string citation_field(std::string_view text, std::string_view name) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('|', begin), text.size());
    const std::string_view field = text.substr(begin, end - begin);
    if (field.starts_with(name) && field.substr(name.size()).starts_with(" = ")) return std::string(field.substr(name.size() + 3));
    begin = end + 1;
  }
  return {};
}

class Keys {
 public:
  explicit Keys(const GeoKeyTags& tags) : tags_(tags) {
    if (tags.directory.size() < 4) return;
    count_ = std::min<std::size_t>(tags.directory[3], (tags.directory.size() - 4) / 4);
  }

  [[nodiscard]] bool empty() const { return count_ == 0; }

  [[nodiscard]] std::optional<int> code(GeoKey key) const {
    const auto entry = find(key);
    if (!entry || entry->location != 0 || entry->count > 1) return std::nullopt;
    return entry->value;
  }

  [[nodiscard]] std::optional<double> number(GeoKey key) const {
    const auto entry = find(key);
    if (!entry) return std::nullopt;
    if (entry->location == 0) return entry->value;
    if (entry->location != kDoubleTag || entry->count < 1 || entry->value >= tags_.doubles.size()) return std::nullopt;
    const double value = tags_.doubles[entry->value];
    if (!std::isfinite(value)) return std::nullopt;
    return value;
  }
  [[nodiscard]] std::optional<double> first_number(std::initializer_list<GeoKey> keys) const {
    for (const GeoKey key : keys) {
      if (const auto value = number(key)) return value;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::string text(GeoKey key) const {
    const auto entry = find(key);
    if (!entry || entry->location != kAsciiTag || entry->value > tags_.ascii.size()) return {};
    return cleaned(std::string_view(tags_.ascii).substr(entry->value, entry->count));
  }

 private:
  struct Entry {
    std::uint16_t location;
    std::uint16_t count;
    std::uint16_t value;  // the value itself, or an index into the tag `location`
  };
  [[nodiscard]] std::optional<Entry> find(GeoKey key) const {
    for (std::size_t i = 0; i < count_; ++i) {
      const std::uint16_t* entry = tags_.directory.data() + 4 + 4 * i;
      if (entry[0] == static_cast<std::uint16_t>(key)) return Entry{entry[1], entry[2], entry[3]};
    }
    return std::nullopt;
  }

  const GeoKeyTags& tags_;
  std::size_t count_ = 0;
};

tl::unexpected<Error> refuse(std::string what) { return fail(ErrorCode::kUnsupported, std::move(what)); }

// A code that says something: neither absent nor 0 nor user-defined.
std::optional<int> registered_code(const Keys& keys, GeoKey key) {
  const auto code = keys.code(key);
  return code && *code != 0 && *code != kUserDefined ? code : std::nullopt;
}

std::string method_text(int method) {
  const bool is_known = method > 0 && static_cast<std::size_t>(method) < kMethodNames.size();
  return is_known ? fmt::format("method {} ({})", method, kMethodNames[static_cast<std::size_t>(method)])
                  : fmt::format("method {}", method);
}

// The CRS's name out of a citation: some writers put one field or a whole definition there.
std::string name_in_citation(const std::string& citation) {
  for (const char* field : {"PCS Name", "GCS Name"}) {
    if (std::string name = citation_field(citation, field); !name.empty()) return name;
  }
  for (const std::string_view opening : {"PROJCS[\"", "GEOGCS[\""}) {
    const std::size_t found = citation.find(opening);
    if (found == std::string::npos) continue;
    const std::size_t begin = found + opening.size();
    return citation.substr(begin, citation.find('"', begin) - begin);
  }
  return citation.substr(0, citation.find('|'));
}

std::string crs_name(const Keys& keys) {
  for (const GeoKey key : {kProjectedCitation, kCitation, kGeographicCitation}) {
    const std::string name = name_in_citation(keys.text(key));
    if (!name.empty() && name != "unnamed" && name != "unknown" && name != "Unknown") return name;
  }
  return {};
}

// As geo_keys_from_crs writes rasters without a place on the Earth.
bool is_pixel(const Keys& keys) { return keys.code(kModelType) == kUserDefined && keys.text(kCitation) == kPixelCitation; }

// What the keys call their CRS, "" when they declare none: a file may carry nothing but the kind of its
// samples.
std::string declared_crs(const Keys& keys) {
  const int model = keys.code(kModelType).value_or(0);
  const auto projected = registered_code(keys, kProjectedType);
  const auto geographic = registered_code(keys, kGeographicType);
  const auto projection = registered_code(keys, kProjection);
  const auto method = registered_code(keys, kCoordinateTransform);
  const std::string name = crs_name(keys);
  const bool has_datum = registered_code(keys, kGeodeticDatum) || registered_code(keys, kEllipsoid) || keys.number(kSemiMajorAxis);
  const bool has_name = model != 0 && !name.empty();  // otherwise it is any text
  if (!projected && !geographic && !projection && !method && !has_datum && !has_name && model != kModelGeocentric) return {};
  const std::string quoted = name.empty() ? "" : fmt::format(" \"{}\"", name);
  if (projected) return fmt::format("EPSG:{}{}", *projected, quoted);
  if (geographic && model != kModelProjected && !method && !projection) return fmt::format("EPSG:{}{}", *geographic, quoted);
  std::string text = model == kModelGeographic   ? "a geographic CRS of its own"
                     : model == kModelGeocentric ? "a geocentric CRS"
                     : model == kModelProjected  ? "a projected CRS of its own"
                                                 : "a CRS of its own";
  text += quoted;
  if (projection) text += fmt::format(", projection {}", *projection);
  if (method) text += ", " + method_text(*method);
  return text;
}

Result<double> degrees_per_angle(const Keys& keys) {
  const int code = keys.code(kAngularUnits).value_or(9102);
  if (code == kUserDefined) {
    const double radians = keys.number(kAngularUnitSize).value_or(0.0);
    if (!(radians > 0.0)) return refuse("the GeoKeys define an angular unit of their own without a usable size (key 2055)");
    const double degrees = radians * 57.295779513082320877;
    return std::abs(degrees - 1.0) < 1e-8 ? 1.0 : degrees;  // pi / 180 is written with few digits at times
  }
  const auto degrees = degrees_from_angle_unit(code);
  if (!degrees) return refuse(fmt::format("GeoKey 2054 names angular unit {}, which this program does not know", code));
  return *degrees;
}

// metres; a file that names no unit means metres.
Result<double> metres_per_length(const Keys& keys, double fallback) {
  const int code = keys.code(kLinearUnits).value_or(0);
  if (code == 0) return fallback;
  if (code == kUserDefined) {
    const double metres = keys.number(kLinearUnitSize).value_or(1.0);
    if (!(metres > 0.0)) return refuse("GeoKey 3077 gives a coordinate unit without size");
    return metres;
  }
  const auto metres = metres_from_length_unit(code);
  if (!metres) return refuse(fmt::format("GeoKey 3076 names length unit {}, which this program does not know", code));
  return *metres;
}

CrsKind kind_of(const CrsDefinition& definition) { return info_of(definition.projection).kind; }

// The geographic CRS underneath: by code, or put together from datum and ellipsoid keys.
Result<CrsDefinition> geographic_base(const Keys& keys) {
  const bool other_meridian =
      keys.code(kPrimeMeridian).value_or(kGreenwich) != kGreenwich || keys.number(kPrimeMeridianLongitude).value_or(0.0) != 0.0;
  if (other_meridian) return refuse("longitudes count from a prime meridian other than Greenwich (GeoKeys 2051, 2061)");

  const int code = keys.code(kGeographicType).value_or(kUserDefined);
  if (code != kUserDefined && code != 0) {
    auto registered = definition_from_epsg(code);
    if (!registered || kind_of(*registered) != CrsKind::kGeographic) {
      return refuse(fmt::format("GeoKey 2048 names geographic CRS EPSG:{}, which this program does not know", code));
    }
    return *std::move(registered);
  }

  CrsDefinition base;
  base.projection = Geographic{};
  const std::string citation = keys.text(kGeographicCitation);
  const std::string named = citation_field(citation, "GCS Name");
  base.datum = named.empty() ? citation : named;
  bool ellipsoid_known = false;
  if (const auto registered = geographic_from_datum(keys.code(kGeodeticDatum).value_or(0))) {
    base.datum = registered->datum;
    base.datum_epsg = registered->datum_epsg;
    base.ellipsoid = registered->ellipsoid;
    ellipsoid_known = true;
  }
  if (const auto registered = ellipsoid_from_epsg(keys.code(kEllipsoid).value_or(0))) {
    base.ellipsoid = *registered;
    ellipsoid_known = true;
  }
  const auto semi_major_m = keys.number(kSemiMajorAxis);
  const auto semi_minor_m = keys.number(kSemiMinorAxis);
  const auto inverse_flattening = keys.number(kInverseFlattening);
  if (semi_major_m && !ellipsoid_known && (semi_minor_m || inverse_flattening)) {
    const std::string name = citation_field(citation, "Ellipsoid");
    base.ellipsoid.name = name.empty() ? "user-defined" : name;
    base.ellipsoid.semi_major_m = *semi_major_m;
    if (inverse_flattening) {
      base.ellipsoid.inverse_flattening = *inverse_flattening;
    } else {
      base.ellipsoid.inverse_flattening = *semi_major_m == *semi_minor_m ? 0.0 : *semi_major_m / (*semi_major_m - *semi_minor_m);
    }
    ellipsoid_known = true;
  }
  if (!ellipsoid_known) return refuse("the GeoKeys name neither a known geographic CRS nor a datum nor an ellipsoid");
  base.name = base.datum;
  return base;
}

Result<CrsDefinition> geographic_crs(const Keys& keys) {
  VT_ASSIGN(CrsDefinition definition, geographic_base(keys));
  VT_ASSIGN(const double degrees, degrees_per_angle(keys));
  if (degrees != 1.0) return refuse(fmt::format("coordinates are angles in a unit of {} degree, not degrees", degrees));
  return definition;
}

// Universal transverse Mercator by projection code: 16001..16060 north, 16101..16160 south.
std::optional<TransverseMercator> utm_zone(int projection_code) {
  const bool is_south = projection_code > 16100;
  const int zone = projection_code - (is_south ? 16100 : 16000);
  if (projection_code < 16001 || zone < 1 || zone > 60) return std::nullopt;
  return TransverseMercator::utm(zone, is_south);
}

// "transverse Mercator (1), Mercator (7)".
std::string known_methods() {
  std::string list;
  for_each_method([&](const auto& method) {
    if (method.kInfo.geo_key != 0) list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", method.kInfo.title, method.kInfo.geo_key);
  });
  return list;
}

// In the units of a file.
struct FileUnits {
  double degrees = 1.0;
  double metres = 1.0;

  [[nodiscard]] double size(ParameterKind kind) const {
    switch (kind) {
      case ParameterKind::kLongitude:
      case ParameterKind::kLatitude:
        return degrees;
      case ParameterKind::kLength:
        return metres;
      case ParameterKind::kRatio:
        return 1.0;
    }
    return 1.0;
  }
};

template <class Method>
Result<Projection> read_method(const Keys& keys, const FileUnits& units) {
  Method method;
  for (const Parameter<Method>& parameter : Method::parameters()) {
    auto value = keys.number(parameter.geo_key);
    for (const GeoKey other : parameter.other_geo_keys)
      if (!value) value = keys.number(other);
    if (!value && parameter.is_required)
      return refuse(
          fmt::format("a {} without a {} (GeoKey {})", Method::kInfo.title, parameter.label, static_cast<int>(parameter.geo_key)));
    if (value) method.*parameter.value = *value * units.size(parameter.kind);
  }
  return Projection(method);
}

// The method that GeoKey 3075 names, with the parameters of the others.
Result<Projection> projection_of_method(const Keys& keys, int number, const FileUnits& units) {
  Result<Projection> found =
      refuse(number == 0 ? std::string("the GeoKeys name no projection method (keys 3074, 3075)")
                         : fmt::format("GeoKey 3075 names projection {}; this program reads {}", method_text(number), known_methods()));
  for_each_method([&]<class Method>(const Method&) {
    if (number != 0 && number == Method::kInfo.geo_key) found = read_method<Method>(keys, units);
  });
  return found;
}

// The projection that GeoKey 3074 names, or its own.
Result<Projection> user_defined_projection(const Keys& keys, double metres_per_unit) {
  const int code = keys.code(kProjection).value_or(kUserDefined);
  const int method = keys.code(kCoordinateTransform).value_or(0);
  if (const auto utm = utm_zone(code)) return Projection(*utm);
  const bool is_named = code != kUserDefined && code != 0;
  if (is_named && code > 16000 && code <= 16160) return refuse(fmt::format("GeoKey 3074 names projection {}, which is no UTM zone", code));
  if (is_named && method == 0)
    return refuse(fmt::format("GeoKey 3074 names projection {}, which this program does not know (it knows UTM zones)", code));
  VT_ASSIGN(const double degrees, degrees_per_angle(keys));
  return projection_of_method(keys, method, {.degrees = degrees, .metres = metres_per_unit});
}

Result<CrsDefinition> user_defined_crs(const Keys& keys) {
  VT_ASSIGN(const double metres_per_unit, metres_per_length(keys, 1.0));
  VT_ASSIGN(Projection projection, user_defined_projection(keys, metres_per_unit));
  VT_ASSIGN(CrsDefinition definition, geographic_base(keys));
  definition.epsg = 0;
  definition.metres_per_unit = metres_per_unit;
  definition.projection = std::move(projection);
  const std::string projected_citation = keys.text(kProjectedCitation);
  const std::string citation = keys.text(kCitation);
  definition.name = !citation.empty() ? citation : projected_citation;
  if (definition.name.empty()) definition.name = fmt::format("{} / {}", definition.datum, info_of(definition.projection).title);
  return definition;
}

Result<CrsDefinition> projected_crs(const Keys& keys) {
  const int code = keys.code(kProjectedType).value_or(kUserDefined);
  if (code == kUserDefined || code == 0) return user_defined_crs(keys);
  auto definition = definition_from_epsg(code);
  if (!definition || kind_of(*definition) == CrsKind::kGeographic) {
    return refuse(fmt::format("GeoKey 3072 names projected CRS EPSG:{}, which this program does not know", code));
  }
  VT_ASSIGN(const double metres, metres_per_length(keys, definition->metres_per_unit));
  if (std::abs(metres - definition->metres_per_unit) > 1e-9 * metres) {  // the same grid counted in another unit
    definition->metres_per_unit = metres;
    definition->epsg = 0;
  }
  return *std::move(definition);
}

Result<CrsDefinition> definition_from_keys(const Keys& keys) {
  const int model = keys.code(kModelType).value_or(0);
  switch (model) {
    case kModelProjected:
      return projected_crs(keys);
    case kModelGeographic:
      return geographic_crs(keys);
    case kModelGeocentric:
      return refuse("coordinates are geocentric (GeoKey 1024 is 3)");
    case 0:
      // Some writers leave it at the one key that says everything.
      if (keys.code(kProjectedType).value_or(kUserDefined) != kUserDefined) return projected_crs(keys);
      return refuse("the GeoKeys do not say whether coordinates are projected or geographic (key 1024 is missing)");
    default:
      return refuse(fmt::format("GeoKey 1024 names model type {}, which is neither projected (1) nor geographic (2)", model));
  }
}

// GeoTIFF 1.0 had numbers of its own for a few vertical systems; their unit is what key 4099 says, or not
// known.
bool is_geotiff_1_0_vertical(int code) { return code >= 5001 && code <= 5106; }

std::optional<VerticalMeaning> vertical_from_keys(const Keys& keys) {
  const int code = keys.code(kVertical).value_or(0);
  const int unit = keys.code(kVerticalUnits).value_or(0);
  const std::string citation = keys.text(kVerticalCitation);
  if (code == 0 && unit == 0 && citation.empty()) return std::nullopt;
  VerticalMeaning vertical{.name = citation, .metres_per_unit = std::nullopt};
  if (is_geotiff_1_0_vertical(code)) {
    vertical.name = fmt::format("GeoTIFF 1.0 vertical system {}", code);
  } else if (code != 0 && code != kUserDefined) {
    vertical = vertical_from_epsg(code);
  }
  if (unit == 0) return vertical;
  const auto metres = metres_from_length_unit(unit);
  const std::optional<double> of_system = vertical.metres_per_unit;
  if (!metres) {
    vertical.unit_problem = unit == kUserDefined ? "a unit of the file's own (GeoKey 4099)" : fmt::format("unit {} (GeoKey 4099)", unit);
  } else if (of_system && std::abs(*of_system - *metres) > 1e-6 * *metres) {
    vertical.unit_problem = fmt::format("{} m (GeoKey 4099) or {} m ({})", *metres, *of_system, vertical.name);
  }
  vertical.metres_per_unit = metres;
  return vertical;
}

// Collects keys in ascending order, as the directory must have them.
class KeyWriter {
 public:
  void code(GeoKey key, int value) { add(key, 0, 1, static_cast<std::uint16_t>(value)); }
  void number(GeoKey key, double value) {
    add(key, kDoubleTag, 1, static_cast<std::uint16_t>(tags_.doubles.size()));
    tags_.doubles.push_back(value);
  }
  void text(GeoKey key, const std::string& value) {
    if (value.empty()) return;
    add(key, kAsciiTag, static_cast<std::uint16_t>(value.size() + 1), static_cast<std::uint16_t>(tags_.ascii.size()));
    tags_.ascii += value + '|';
  }
  GeoKeyTags finish() {
    std::ranges::sort(entries_);
    tags_.directory = {1, 1, 0, static_cast<std::uint16_t>(entries_.size())};
    for (const auto& entry : entries_) tags_.directory.insert(tags_.directory.end(), entry.begin(), entry.end());
    return std::move(tags_);
  }

 private:
  void add(GeoKey key, std::uint16_t location, std::uint16_t count, std::uint16_t value) {
    entries_.push_back({static_cast<std::uint16_t>(key), location, count, value});
  }

  std::vector<std::array<std::uint16_t, 4>> entries_;
  GeoKeyTags tags_;
};

// `by_code`: the EPSG code that is written says everything, and repeating it in numbers would only make other
// readers doubt the code.
void write_geographic(const CrsDefinition& d, bool by_code, KeyWriter& keys) {
  keys.code(kAngularUnits, 9102);
  if (by_code) {
    if (kind_of(d) == CrsKind::kGeographic) keys.code(kGeographicType, d.epsg);
    keys.text(kGeographicCitation, cleaned(d.datum));
    return;
  }
  keys.number(kSemiMajorAxis, d.ellipsoid.semi_major_m);
  if (d.ellipsoid.inverse_flattening == 0.0) {
    keys.number(kSemiMinorAxis, d.ellipsoid.semi_major_m);
  } else {
    keys.number(kInverseFlattening, d.ellipsoid.inverse_flattening);
  }
  if (kind_of(d) == CrsKind::kGeographic && d.epsg != 0) {
    keys.code(kGeographicType, d.epsg);
  } else if (d.datum_epsg != 0) {
    keys.code(kGeographicType, d.datum_epsg);
  } else {
    keys.code(kGeographicType, kUserDefined);
    keys.code(kGeodeticDatum, kUserDefined);
    keys.code(kEllipsoid, kUserDefined);
    const std::string datum = cleaned(d.datum);
    keys.text(kGeographicCitation,
              fmt::format("GCS Name = {}|Datum = {}|Ellipsoid = {}|Primem = Greenwich", datum, datum, cleaned(d.ellipsoid.name)));
    return;
  }
  keys.text(kGeographicCitation, cleaned(d.datum));
}

template <class Method>
void write_method(const Method& method, const FileUnits& units, KeyWriter& keys) {
  keys.code(kProjection, kUserDefined);
  keys.code(kCoordinateTransform, Method::kInfo.geo_key);
  for (const Parameter<Method>& parameter : Method::parameters()) {
    const double value = method.*parameter.value;
    if (parameter.is_omitted_at_default && value == Method{}.*parameter.value) continue;
    keys.number(parameter.geo_key, value / units.size(parameter.kind));
  }
}

void write_projected(const CrsDefinition& d, KeyWriter& keys) {
  const int unit = length_unit_code(d.metres_per_unit);
  keys.code(kLinearUnits, unit == 0 ? kUserDefined : unit);
  if (unit == 0) keys.number(kLinearUnitSize, d.metres_per_unit);
  const int code = d.epsg != 0 ? d.epsg : info_of(d.projection).only_epsg;
  keys.code(kProjectedType, code != 0 ? code : kUserDefined);
  if (code == 0)
    std::visit([&](const auto& method) { write_method(method, {.degrees = 1.0, .metres = d.metres_per_unit}, keys); }, d.projection);
}

}  // namespace

GeoKeyMeaning crs_from_geo_keys(const GeoKeyTags& tags) {
  GeoKeyMeaning meaning;
  const Keys keys(tags);
  meaning.pixel_is_point = keys.code(kRasterType) == kPixelIsPoint;
  if (keys.empty()) {
    if (tags.directory.size() >= 4 && tags.directory[3] == 0) return meaning;  // no keys
    if (!tags.directory.empty()) {
      meaning.declared = "a CRS in damaged GeoKeys";
      meaning.problem = "the GeoKey directory (tag 34735) holds no complete key";
    }
    return meaning;
  }
  meaning.vertical = vertical_from_keys(keys);
  if (is_pixel(keys)) {
    meaning.crs.emplace();
    meaning.declared = kPixelCitation;
    return meaning;
  }
  meaning.declared = declared_crs(keys);
  if (meaning.declared.empty()) return meaning;
  auto definition = definition_from_keys(keys);
  if (!definition) {
    meaning.problem = std::move(definition).error().message;
    return meaning;
  }
  meaning.crs.emplace(*std::move(definition));
  return meaning;
}

GeoKeyTags geo_keys_from_crs(const Crs& crs) {
  const CrsDefinition& d = crs.definition();
  const auto registered = Crs::from_epsg(d.epsg);
  const bool code_says_all = d.epsg != 0 && registered && registered->same_coordinates(crs);
  KeyWriter keys;
  keys.code(kRasterType, 1);
  switch (crs.kind()) {
    case CrsKind::kPixel:
      keys.code(kModelType, kUserDefined);
      keys.text(kCitation, kPixelCitation);
      break;
    case CrsKind::kGeographic:
      keys.code(kModelType, kModelGeographic);
      write_geographic(d, code_says_all, keys);
      break;
    case CrsKind::kProjected:
      keys.code(kModelType, kModelProjected);
      keys.text(kCitation, cleaned(d.name));
      write_geographic(d, code_says_all, keys);
      write_projected(d, keys);
      break;
  }
  return keys.finish();
}

}  // namespace vt::geo
