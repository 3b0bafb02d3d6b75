#include "builder/channels/codec/channel_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "builder/text/names_text.h"

namespace vt::channels {
namespace {

Result<double> parse_number(const std::string& name, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return fail(ErrorCode::kUsage, "option " + name + ": '" + std::string(text) + "' is not a number");
  return value;
}

}  // namespace

Result<std::string> choice_of(const Options& options, const std::string& name, std::string_view preset,
                              std::span<const std::string_view> choices) {
  const auto given = options.find(name);
  if (given == options.end()) return std::string(preset);
  if (std::ranges::find(choices, given->second) != choices.end()) return given->second;
  return fail(ErrorCode::kUsage, "option " + name + ": '" + given->second + "' is none of " + text::names_text(choices));
}

Result<std::optional<double>> number_of(const Options& options, const std::string& name, double least, double greatest) {
  const auto given = options.find(name);
  if (given == options.end()) return std::optional<double>{};
  VT_ASSIGN(const double value, parse_number(name, given->second));
  if (value < least || value > greatest)
    return fail(ErrorCode::kUsage,
                "option " + name + ": " + given->second + " is not from " + std::to_string(least) + " to " + std::to_string(greatest));
  return std::optional(value);
}

Result<std::vector<double>> numbers_of(const Options& options, const std::string& name) {
  std::vector<double> numbers;
  const auto given = options.find(name);
  if (given == options.end()) return numbers;
  const std::string& text = given->second;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    VT_ASSIGN(const double value, parse_number(name, std::string_view(text).substr(at, end - at)));
    numbers.push_back(value);
    at = end + 1;
  }
  return numbers;
}

Result<bool> flag_of(const Options& options, const std::string& name, bool preset) {
  constexpr std::array<std::string_view, 2> kChoices{"yes", "no"};
  VT_ASSIGN(const std::string choice, choice_of(options, name, preset ? "yes" : "no", kChoices));
  return choice == "yes";
}

}  // namespace vt::channels
