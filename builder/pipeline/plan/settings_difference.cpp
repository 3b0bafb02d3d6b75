#include "builder/pipeline/plan/settings_difference.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

namespace vt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostNamed = 3;
constexpr std::size_t kMostValueBytes = 60;

// Members of the settings that users give, by the names that they give them by.
constexpr std::array kGiven =
    std::to_array<std::string_view>({"channel", "format", "kernel", "quality", "compression", "tile", "crs", "range", "resample"});
// Those that follow from others and from the sources.
constexpr std::array kFollowing = std::to_array<std::string_view>({"parts", "edges", "rules"});

struct Setting {
  std::string name;
  bool follows = false;
  Json there;
  Json here;
};

std::string shown(const Json& value) {
  if (value.is_null()) return "not given";
  std::string text = value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > kMostValueBytes) text = text.substr(0, kMostValueBytes) + "...";
  return text;
}

// "a, b, c and 4 more".
std::string joined(const std::vector<std::string>& parts, std::string_view between) {
  std::string text;
  for (std::size_t i = 0; i < std::min(parts.size(), kMostNamed); ++i) text += (i == 0 ? std::string() : std::string(between)) + parts[i];
  if (parts.size() > kMostNamed) text += " and " + std::to_string(parts.size() - kMostNamed) + " more";
  return text;
}

const Json& member_of(const Json& object, const std::string& name) {
  static const Json kNone;
  return object.is_object() && object.contains(name) ? object[name] : kNone;
}

std::vector<std::string> names_in(const Json& a, const Json& b) {
  std::vector<std::string> names;
  for (const Json* object : {&a, &b})
    if (object->is_object())
      for (const auto& [name, value] : object->items())
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  return names;
}

std::vector<Setting> differing_settings(const Json& there, const Json& here) {
  std::vector<Setting> settings;
  for (const std::string& name : names_in(there, here)) {
    const Json& a = member_of(there, name);
    const Json& b = member_of(here, name);
    if (name == "sources" || a == b) continue;
    if (name == "options") {
      for (const std::string& option : names_in(a, b))
        if (member_of(a, option) != member_of(b, option))
          settings.push_back({"`" + option + "`", false, member_of(a, option), member_of(b, option)});
    } else {
      const bool is_given = std::ranges::find(kGiven, name) != kGiven.end();
      settings.push_back({is_given ? "`" + name + "`" : name, std::ranges::find(kFollowing, name) != kFollowing.end(), a, b});
    }
  }
  return settings;
}

std::string name_of(const Json& source) {
  const Json& path = member_of(source, "path");
  return path.is_string() ? path.get<std::string>() : std::string();
}

std::vector<std::string> names_of(const Json& sources) {
  std::vector<std::string> names;
  for (const Json& source : sources) names.push_back(name_of(source));
  return names;
}

// More sources than settings list.
std::string count_of(const Json& sources) {
  const Json& count = member_of(sources, "count");
  return count.is_number() ? count.dump() : std::to_string(sources.is_array() ? sources.size() : 0);
}

}  // namespace

std::string settings_difference(const Json& there, const Json& here) {
  std::vector<Setting> settings = differing_settings(there, here);
  if (std::ranges::any_of(settings, [](const Setting& one) { return !one.follows; }))
    std::erase_if(settings, [](const Setting& one) { return one.follows; });
  std::vector<std::string> texts;
  for (const Setting& one : settings) texts.push_back(one.name + ": " + shown(one.there) + " there, " + shown(one.here) + " here");
  return joined(texts, "; ");
}

std::string source_difference(const Json& there, const Json& here) {
  if (there == here) return {};
  if (!there.is_array() || !here.is_array()) return count_of(there) + " sources there and " + count_of(here) + " here, not all the same";
  const std::vector<std::string> old_names = names_of(there);
  const std::vector<std::string> new_names = names_of(here);
  std::vector<std::string> changed;
  std::vector<std::string> added;
  std::vector<std::string> gone;
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (std::ranges::find(there, here[i]) != there.end()) continue;
    (std::ranges::find(old_names, new_names[i]) != old_names.end() ? changed : added).push_back(new_names[i]);
  }
  for (const std::string& name : old_names)
    if (std::ranges::find(new_names, name) == new_names.end()) gone.push_back(name);
  std::vector<std::string> texts;
  for (const auto& [title, names] : {std::pair("changed: ", &changed), std::pair("new: ", &added), std::pair("gone: ", &gone)})
    if (!names->empty()) texts.push_back(title + joined(*names, ", "));
  return texts.empty() ? "in another order" : joined(texts, "; ");
}

}  // namespace vt::pipeline
