#include "builder/channels/material/class_table.h"

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "builder/text/json_text.h"

namespace vt::channels {
namespace {

using Json = nlohmann::ordered_json;

std::optional<std::string> color_text(const Json& color) {
  if (color.is_string()) {
    std::string text = color.get<std::string>();
    if (text.size() != 7 || text[0] != '#' || text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) return std::nullopt;
    for (char& c : text)
      if (c >= 'A' && c <= 'F') c = static_cast<char>(c - 'A' + 'a');
    return text;
  }
  if (!color.is_array() || color.size() != 3) return std::nullopt;
  unsigned codes[3];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!color[i].is_number_unsigned() || color[i] > 255U) return std::nullopt;
    codes[i] = color[i].get<unsigned>();
  }
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", codes[0], codes[1], codes[2]);
  return text;
}

// One entry as it is kept.
Result<Json> checked_entry(const Json& entry, std::size_t place, const ClassCounting& classes) {
  const auto wrong = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidData, "table of classes, entry " + std::to_string(place + 1) + ": " + what);
  };
  if (!entry.is_object()) return wrong("is not an object {\"id\": ..., \"name\": ..., \"color\": ...}");
  for (const auto& [key, value] : entry.items())
    if (key != "id" && key != "name" && key != "color") return wrong("has a member '" + key + "'; id, name and color are known");
  const auto id = entry.find("id");
  if (id == entry.end() || !id->is_number_integer()) return wrong("has no whole number \"id\"");
  if (*id < 0 || *id > classes.greatest)
    return wrong("id " + id->dump() + ", this layer holds 0 to " + std::to_string(classes.greatest) +
                 (classes.greatest < 65535 ? "; as r16 it would hold all to 65535" : ""));
  if (*id == classes.no_data) return wrong("id " + id->dump() + " stands for no data in this layer; choose another with no-data-class");
  const auto name = entry.find("name");
  if (name == entry.end() || !name->is_string() || name->get<std::string>().empty()) return wrong("has no \"name\"");
  Json kept{{"id", *id}, {"name", *name}};
  if (entry.contains("color")) {
    const std::optional<std::string> color = color_text(entry["color"]);
    if (!color) return wrong("\"color\" is neither \"#rrggbb\" nor three numbers from 0 to 255");
    kept["color"] = *color;
  }
  return kept;
}

}  // namespace

Result<std::string> checked_class_table(std::string_view table, const ClassCounting& classes) {
  const auto parsed = text::parse_ordered_json(table);
  if (!parsed) return fail(ErrorCode::kInvalidData, "table of classes: " + parsed.error().message);
  const Json& document = *parsed;
  const Json& list = document.is_object() && document.contains("classes") ? document["classes"] : document;
  if (!list.is_array()) return fail(ErrorCode::kInvalidData, "table of classes: is neither a list nor an object with a list \"classes\"");
  std::map<int, Json> by_id;
  for (std::size_t i = 0; i < list.size(); ++i) {
    VT_ASSIGN(Json entry, checked_entry(list[i], i, classes));
    const int id = entry["id"].get<int>();
    if (!by_id.emplace(id, std::move(entry)).second)
      return fail(ErrorCode::kInvalidData,
                  "table of classes, entry " + std::to_string(i + 1) + ": id " + std::to_string(id) + " is there already");
  }
  Json sorted = Json::array();
  for (auto& [id, entry] : by_id) sorted.push_back(std::move(entry));
  return sorted.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace vt::channels
