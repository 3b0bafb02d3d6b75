#include "builder/channels/sensor/sensor_quantity.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <ranges>
#include <span>
#include <string>

#include "builder/channels/codec/channel_options.h"
#include "builder/channels/sensor/spectral_response.h"
#include "builder/channels/shared/radiance_unit.h"
#include "store/channel.h"

namespace vt::channels {
namespace {

using Kind = SensorQuantity::Kind;

// In the order of the enumerators.
constexpr std::array<std::string_view, 4> kKinds{"radiance", "reflectance", "emissivity", "temperature"};

bool is_ratio(Kind kind) { return kind == Kind::kReflectance || kind == Kind::kEmissivity; }

// LOW,HIGH; where nothing is said, what can be assumed of the quantity.
Result<std::optional<std::array<double, 2>>> span_of(const Options& options, const SensorQuantity& quantity) {
  VT_ASSIGN(const std::vector<double> numbers, numbers_of(options, "span"));
  if (!numbers.empty()) {
    if (numbers.size() != 2 || numbers[0] >= numbers[1])
      return fail(ErrorCode::kUsage, "option span: '" + options.at("span") + "' is not LOW,HIGH with the lower number first");
    return std::optional(std::array<double, 2>{numbers[0], numbers[1]});
  }
  if (is_ratio(quantity.kind)) return std::optional(std::array<double, 2>{0.0, 1.0});
  return std::optional<std::array<double, 2>>{};
}

// A unit in which an input may be declared: value in the channel's unit = add + times * number.
struct UnitRow {
  std::string_view name;  // lower case, without spaces
  double times = 1.0;
  double add = 0.0;
};
constexpr std::array kTemperatures = std::to_array<UnitRow>({{"k"},
                                                             {"kelvin"},
                                                             {"kelvins"},
                                                             {"degk"},
                                                             {"c", 1.0, 273.15},
                                                             {"degc", 1.0, 273.15},
                                                             {"celsius", 1.0, 273.15},
                                                             {"degreecelsius", 1.0, 273.15},
                                                             {"degreescelsius", 1.0, 273.15},
                                                             {"\u00b0c", 1.0, 273.15},
                                                             {"f", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0},
                                                             {"degf", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0},
                                                             {"fahrenheit", 5.0 / 9.0, 273.15 - 32.0 * 5.0 / 9.0}});
constexpr std::array kRatios = std::to_array<UnitRow>(
    {{"1"}, {"none"}, {"unitless"}, {"ratio"}, {"fraction"}, {"reflectance"}, {"emissivity"}, {"%", 0.01}, {"percent", 0.01}});
constexpr std::array kBandRadiances =
    std::to_array<UnitRow>({{"w/(m2sr)"}, {"w/(m^2sr)"}, {"w/m2/sr"}, {"w/m^2/sr"}, {"wm-2sr-1"}, {"w.m-2.sr-1"}, {"w*m-2*sr-1"}});

std::string plain_unit(std::string_view text) {
  std::string plain;
  for (const char c : text)
    if (c != ' ' && c != '\t') plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return plain;
}

// The input's numbers come in the unit that is declared for them; what is averaged is in the channel's.
Result<void> convert_unit(const Options& options, const SampleLayout& layout, SensorQuantity& quantity) {
  const auto given = options.find("input-unit");
  const std::string& text = given != options.end() ? given->second : layout.unit;
  if (text.empty()) return {};
  const bool is_free_radiance = quantity.kind == Kind::kRadiance && !quantity.band;
  if (is_free_radiance) {  // any unit will do, and it is the layer's unless the user names another
    if (!options.contains("unit") && !quantity.stores_temperature) quantity.unit = text;
    return {};
  }
  const std::span<const UnitRow> known = quantity.kind == Kind::kTemperature ? std::span<const UnitRow>(kTemperatures)
                                         : quantity.kind == Kind::kRadiance  ? std::span<const UnitRow>(kBandRadiances)
                                                                             : std::span<const UnitRow>(kRatios);
  const auto row = std::ranges::find(known, std::string_view(plain_unit(text)), &UnitRow::name);
  if (row == known.end()) {
    const std::string wanted = quantity.kind == Kind::kTemperature ? "K, C or F"
                               : quantity.kind == Kind::kRadiance  ? "W/(m2 sr)"
                                                                   : "1 or %";
    const std::string kind(kKinds[static_cast<std::size_t>(quantity.kind)]);
    if (given != options.end())
      return fail(ErrorCode::kUsage, "option input-unit: '" + text + "' is no unit of " + kind + " that is known; use " + wanted);
    return fail(ErrorCode::kInvalidData, "declares its values in '" + text + "', which is no unit of " + kind +
                                             " that is known; say what they are with input-unit (" + wanted +
                                             "), with input-scale and input-offset if they need it");
  }
  quantity.scale *= row->times;
  quantity.offset = row->add + row->times * quantity.offset;
  return {};
}

std::string metadata_of(const SensorQuantity& quantity, const std::vector<ResponsePoint>& response) {
  nlohmann::ordered_json metadata;
  metadata["quantity"] = stored_name(quantity);
  metadata["input_quantity"] = kKinds[static_cast<std::size_t>(quantity.kind)];
  if (!response.empty()) metadata["band_um"] = {response.front().wavelength_um, response.back().wavelength_um};
  if (response.size() > 2) {
    for (const ResponsePoint& point : response) {
      metadata["response"]["wavelength_um"].push_back(point.wavelength_um);
      metadata["response"]["response"].push_back(point.response);
    }
  }
  return metadata.dump();
}

}  // namespace

std::string_view stored_name(const SensorQuantity& quantity) {
  const Kind stored = quantity.stores_temperature           ? Kind::kTemperature
                      : quantity.kind == Kind::kTemperature ? Kind::kRadiance
                                                            : quantity.kind;
  return kKinds[static_cast<std::size_t>(stored)];
}

Result<SensorQuantity> sensor_quantity(const Options& options, const SampleLayout& layout) {
  SensorQuantity quantity;
  VT_ASSIGN(const std::string kind, choice_of(options, "quantity", "radiance", kKinds));
  quantity.kind = static_cast<Kind>(std::find(kKinds.begin(), kKinds.end(), kind) - kKinds.begin());

  constexpr double kMost = std::numeric_limits<float>::max();
  VT_ASSIGN(const auto scale, number_of(options, "input-scale", -kMost, kMost));
  VT_ASSIGN(const auto offset, number_of(options, "input-offset", -kMost, kMost));
  quantity.scale = scale.value_or(layout.scale.value_or(1.0));
  quantity.offset = offset.value_or(layout.offset.value_or(0.0));
  if (quantity.scale == 0.0)
    return scale ? fail(ErrorCode::kUsage, "option input-scale: 0 makes all samples equal")
                 : fail(ErrorCode::kInvalidData, "declares a scale of 0, which makes all samples equal; give another with input-scale");

  constexpr std::array<std::string_view, 2> kStores{"radiance", "temperature"};
  VT_ASSIGN(const std::string store, choice_of(options, "store", "radiance", kStores));
  if (options.contains("store") && is_ratio(quantity.kind))
    return fail(ErrorCode::kUsage, "option store: " + kind + " is stored as it is; radiance or temperature are of thermal layers");
  quantity.stores_temperature = store == "temperature";

  VT_ASSIGN(const std::vector<ResponsePoint> response, response_of(options));
  const bool is_thermal = !is_ratio(quantity.kind);
  if (response.empty() && (quantity.kind == Kind::kTemperature || quantity.stores_temperature))
    return fail(ErrorCode::kUsage,
                "temperatures average as radiance in a band; give it with `band` LOW,HIGH in micrometres, for example "
                "`band` 8,12, or as a table with `response` FILE");
  // A band of reflected light says nothing of temperatures.
  if (!response.empty() && is_thermal) quantity.band = std::make_shared<const BandRadiance>(response);

  const auto unit = options.find("unit");
  quantity.unit = quantity.stores_temperature ? "K" : is_ratio(quantity.kind) ? "" : std::string(kRadianceUnit);
  if (unit != options.end()) {
    if (quantity.kind != Kind::kRadiance || quantity.stores_temperature)
      return fail(ErrorCode::kUsage, "option unit: only radiance that stays radiance has a unit to choose; " + kind + " has its own");
    if (quantity.band) return fail(ErrorCode::kUsage, "option unit: with a band, radiance is in W/(m2 sr); leave one of the two out");
    quantity.unit = unit->second;
  }
  VT_CHECK(convert_unit(options, layout, quantity));
  VT_ASSIGN(quantity.span, span_of(options, quantity));
  quantity.metadata_json = metadata_of(quantity, response);
  return quantity;
}

}  // namespace vt::channels
