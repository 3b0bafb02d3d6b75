#include "builder/channels/shared/declared_unit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "builder/channels/shared/angle.h"

namespace vt::channels {
namespace {

constexpr double kFoot = 0.3048;
constexpr double kUsSurveyFoot = 1200.0 / 3937.0;

struct Row {
  std::string_view name;  // lower case, single spaces
  double size;            // in metres or radians
};

constexpr std::array kLengths = std::to_array<Row>({
    {"m", 1.0},
    {"metre", 1.0},
    {"metres", 1.0},
    {"meter", 1.0},
    {"meters", 1.0},
    {"ft", kFoot},
    {"foot", kFoot},
    {"feet", kFoot},
    {"international foot", kFoot},
    {"international feet", kFoot},
    {"foot (international)", kFoot},
    {"us-ft", kUsSurveyFoot},
    {"ftus", kUsSurveyFoot},
    {"us ft", kUsSurveyFoot},
    {"usft", kUsSurveyFoot},
    {"sft", kUsSurveyFoot},
    {"foot_us", kUsSurveyFoot},
    {"us foot", kUsSurveyFoot},
    {"us feet", kUsSurveyFoot},
    {"us survey foot", kUsSurveyFoot},
    {"us survey feet", kUsSurveyFoot},
    {"u.s. survey foot", kUsSurveyFoot},
    {"u.s. survey feet", kUsSurveyFoot},
    {"survey foot", kUsSurveyFoot},
    {"survey feet", kUsSurveyFoot},
    {"mm", 0.001},
    {"millimetre", 0.001},
    {"millimetres", 0.001},
    {"millimeter", 0.001},
    {"millimeters", 0.001},
    {"cm", 0.01},
    {"centimetre", 0.01},
    {"centimetres", 0.01},
    {"centimeter", 0.01},
    {"centimeters", 0.01},
    {"dm", 0.1},
    {"decimetre", 0.1},
    {"decimetres", 0.1},
    {"decimeter", 0.1},
    {"decimeters", 0.1},
    {"km", 1000.0},
    {"kilometre", 1000.0},
    {"kilometres", 1000.0},
    {"kilometer", 1000.0},
    {"kilometers", 1000.0},
    {"yd", 0.9144},
    {"yard", 0.9144},
    {"yards", 0.9144},
    {"fathom", 1.8288},
    {"fathoms", 1.8288},
});

constexpr std::array kAngles = std::to_array<Row>({
    {"rad", 1.0},
    {"radian", 1.0},
    {"radians", 1.0},
    {"mrad", 0.001},
    {"deg", kRadiansPerDegree},
    {"degree", kRadiansPerDegree},
    {"degrees", kRadiansPerDegree},
    {"\u00B0", kRadiansPerDegree},
});

// Lower case, without white space around and with single spaces between the words.
std::string plain(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const bool is_space = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (is_space) {
      if (!result.empty() && result.back() != ' ') result += ' ';
    } else {
      result += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    }
  }
  while (!result.empty() && result.back() == ' ') result.pop_back();
  return result;
}

}  // namespace

std::optional<double> metres_of_unit(std::string_view unit) {
  const std::string name = plain(unit);
  const auto* const row = std::ranges::find(kLengths, std::string_view(name), &Row::name);
  if (row != kLengths.end()) return row->size;
  double metres = 0.0;
  const auto [end, status] = std::from_chars(name.data(), name.data() + name.size(), metres);
  const std::string_view rest(end, static_cast<std::size_t>(name.data() + name.size() - end));
  if (status != std::errc{} || !std::isfinite(metres) || metres <= 0.0 || (rest != "m" && rest != " m")) return std::nullopt;
  return metres;
}

std::optional<double> radians_of_unit(std::string_view unit) {
  const std::string name = plain(unit);
  const auto* const row = std::ranges::find(kAngles, std::string_view(name), &Row::name);
  return row != kAngles.end() ? std::optional(row->size) : std::nullopt;
}

}  // namespace vt::channels
