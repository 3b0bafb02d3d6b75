#include "tools/vtinspect/quality_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "builder/channels/all_channels.h"
#include "store/channel.h"
#include "store/format/text.h"

namespace vt::inspect {
namespace {

using Json = nlohmann::ordered_json;

// A member of an object, or null.
const Json& member(const Json& json, const char* name) {
  static const Json nothing;
  if (!json.is_object()) return nothing;
  const auto found = json.find(name);
  return found == json.end() ? nothing : *found;
}

std::string text_of(const Json& json) { return json.is_string() ? store::printable(json.get<std::string>()) : std::string(); }

std::string number_text(const Json& row, const char* name, std::string_view format) {
  const Json& number = member(row, name);
  return number.is_number() ? fmt::format(fmt::runtime(format), number.get<double>()) : std::string("-");
}

// For errors that are shares of full scale.
std::string decibels_text(const Json& row) {
  const Json& rms = member(row, "rms");
  if (!rms.is_number()) return "-";
  const double value = rms.get<double>();
  return value > 0.0 ? fmt::format("{:.1f}", -20.0 * std::log10(value)) : std::string("exact");
}

}  // namespace

std::vector<std::string> component_names(const Json& metadata) {
  std::vector<std::string> names;
  for (const Json& name : member(metadata, "components")) names.push_back(text_of(name));
  return names;
}

std::string unit_of(const LayerInfo& layer, const Json& metadata) {
  const Json& unit = member(metadata, "unit");
  return unit.is_string() ? text_of(unit) : std::string(channels::kind_of(layer.channel).unit);
}

std::string quality_table(const Json& metadata) {
  std::string text;
  for (const Json& measure : member(metadata, "quality")) {
    const Json& levels = member(measure, "levels");
    if (!levels.is_array() || levels.empty()) continue;
    const std::string unit = text_of(member(measure, "unit"));
    constexpr std::string_view kRow = "  {:>5}  {:>11}  {:>11}  {:>11}  {:>7}  {:>10}  {:>12}\n";
    text += fmt::format("  error of {}{}\n", text_of(member(measure, "name")), unit.empty() ? "" : " in " + unit);
    text += fmt::format(fmt::runtime(kRow), "level", "mean", "rms", "max", unit.empty() ? "dB" : "", "kept", "measured");
    for (const Json& row : levels)
      text += fmt::format(fmt::runtime(kRow), number_text(row, "level", "{:.0f}"), number_text(row, "mean", "{:.4g}"),
                          number_text(row, "rms", "{:.4g}"), number_text(row, "max", "{:.4g}"), unit.empty() ? decibels_text(row) : "",
                          number_text(row, "kept", "{:.6f}"), number_text(row, "measured", "{:.0f}"));
  }
  return text;
}

}  // namespace vt::inspect
