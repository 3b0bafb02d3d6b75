#include "builder/channels/sensor/spectral_response.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "builder/channels/codec/channel_options.h"
#include "builder/text/json_text.h"

namespace vt::channels {
namespace {

// Where the exponent of Planck's law stays within doubles for temperatures that matter, and beyond every
// thermal sensor.
constexpr double kShortest = 0.2;
constexpr double kLongest = 1000.0;

tl::unexpected<Error> bad(const std::string& what) { return fail(ErrorCode::kInvalidData, "spectral response: " + what); }

// Two numbers and nothing else.
std::optional<ResponsePoint> point_of(std::string_view line) {
  ResponsePoint point;
  for (double* number : {&point.wavelength_um, &point.response}) {
    line.remove_prefix(std::min(line.find_first_not_of(number == &point.response ? " \t,;" : " \t"), line.size()));
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), *number);
    if (error != std::errc{}) return std::nullopt;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  }
  return line.find_first_not_of(" \t\r,;") == std::string_view::npos ? std::optional(point) : std::nullopt;
}

Result<std::vector<ResponsePoint>> parse_lines(std::string_view text) {
  std::vector<ResponsePoint> points;
  bool may_be_headings = true;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos || line[begin] == '#') continue;
    const auto point = point_of(line);
    if (point) points.push_back(*point);
    if (!point && !may_be_headings) return bad("line " + std::to_string(number) + " is not a wavelength and a response");
    may_be_headings = false;
  }
  return points;
}

Result<std::vector<ResponsePoint>> parse_json(std::string_view table) {
  const auto parsed = text::parse_json(table);
  if (!parsed) return bad(parsed.error().message);
  const nlohmann::json& json = *parsed;
  const auto numbers = [&](const char* name) -> std::optional<std::vector<double>> {
    if (!json.is_object() || !json.contains(name) || !json[name].is_array()) return std::nullopt;
    std::vector<double> values;
    for (const auto& value : json[name]) {
      if (!value.is_number()) return std::nullopt;
      values.push_back(value.get<double>());
    }
    return values;
  };
  const auto wavelengths = numbers("wavelength_um");
  const auto responses = numbers("response");
  if (!wavelengths || !responses || wavelengths->size() != responses->size())
    return bad("JSON must hold the arrays \"wavelength_um\" and \"response\", numbers, as many of one as of the other");
  std::vector<ResponsePoint> points;
  for (std::size_t i = 0; i < wavelengths->size(); ++i) points.push_back({(*wavelengths)[i], (*responses)[i]});
  return points;
}

double response_at(const std::vector<ResponsePoint>& points, double wavelength_um) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    const ResponsePoint& a = points[i - 1];
    const ResponsePoint& b = points[i];
    if (wavelength_um < a.wavelength_um || wavelength_um > b.wavelength_um) continue;
    return a.response + (b.response - a.response) * (wavelength_um - a.wavelength_um) / (b.wavelength_um - a.wavelength_um);
  }
  return 0.0;
}

bool is_all_zero(const std::vector<ResponsePoint>& points) {
  return std::all_of(points.begin(), points.end(), [](const ResponsePoint& point) { return point.response == 0.0; });
}

// What lies between the edges, with new corners at them.
std::vector<ResponsePoint> cut(const std::vector<ResponsePoint>& points, double low, double high) {
  std::vector<ResponsePoint> result{{low, response_at(points, low)}};
  for (const ResponsePoint& point : points)
    if (point.wavelength_um > low && point.wavelength_um < high) result.push_back(point);
  result.push_back({high, response_at(points, high)});
  return result;
}

}  // namespace

Result<std::vector<ResponsePoint>> parse_response(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  const bool is_json = begin != std::string_view::npos && text[begin] == '{';
  VT_ASSIGN(std::vector<ResponsePoint> points, is_json ? parse_json(text) : parse_lines(text));
  if (points.size() < 2) return bad("found " + std::to_string(points.size()) + " points, 2 are needed at least");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ResponsePoint& point = points[i];
    const std::string place = "wavelength " + std::to_string(point.wavelength_um);
    if (!(point.wavelength_um >= kShortest && point.wavelength_um <= kLongest))
      return bad(place + " is not from 0.2 to 1000 micrometres" + (point.wavelength_um > kLongest ? "; is it in nanometres?" : ""));
    if (!(point.response >= 0.0) || !std::isfinite(point.response))
      return bad(place + ": the response is " + std::to_string(point.response) + ", it must be a number from 0 on");
    if (i > 0 && point.wavelength_um <= points[i - 1].wavelength_um) return bad(place + " is not above the one before it");
  }
  if (is_all_zero(points)) return bad("it is 0 everywhere");
  return points;
}

Result<std::vector<ResponsePoint>> response_of(const Options& options) {
  VT_ASSIGN(const std::vector<double> band, numbers_of(options, "band"));
  const bool has_band = !band.empty();
  if (has_band && (band.size() != 2 || !(band[0] >= kShortest && band[0] < band[1] && band[1] <= kLongest)))
    return fail(ErrorCode::kUsage, "option band: '" + options.at("band") +
                                       "' is not LOW,HIGH in micrometres, from 0.2 to 1000 and the lower edge first; for example 8,12");
  const auto table = options.find("response");
  if (table == options.end()) return has_band ? std::vector<ResponsePoint>{{band[0], 1.0}, {band[1], 1.0}} : std::vector<ResponsePoint>{};
  VT_ASSIGN(std::vector<ResponsePoint> points, parse_response(table->second));
  if (!has_band) return points;
  std::vector<ResponsePoint> inside = cut(points, band[0], band[1]);
  if (is_all_zero(inside)) return fail(ErrorCode::kUsage, "option band: the response is 0 all over " + options.at("band"));
  return inside;
}

}  // namespace vt::channels
