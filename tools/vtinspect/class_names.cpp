#include "tools/vtinspect/class_names.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "builder/channels/all_channels.h"
#include "builder/text/json_text.h"
#include "store/format/text.h"

namespace vt::inspect {
namespace {

using Json = nlohmann::json;

std::optional<std::array<std::uint8_t, 3>> color_from(const std::string& text) {
  std::uint32_t rgb = 0;
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), rgb, 16);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return std::array{static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8), static_cast<std::uint8_t>(rgb)};
}

std::optional<int> code_from(const Json& object, const char* member) {
  const auto found = object.find(member);
  if (found == object.end() || !found->is_number_integer() || *found < 0 || *found > channels::kGreatestClass) return std::nullopt;
  return found->get<int>();
}

std::string text_from(const Json& object, const char* member) {
  const auto found = object.find(member);
  return found != object.end() && found->is_string() ? store::printable(found->get<std::string>()) : std::string();
}

}  // namespace

std::string ClassTable::name_of(int code) const {
  if (no_data == code) return "no data";
  const auto found = classes.find(code);
  return found == classes.end() ? std::string() : found->second.name;
}

std::optional<std::array<std::uint8_t, 3>> ClassTable::color_of(int code) const {
  if (no_data == code) return std::nullopt;
  const auto found = classes.find(code);
  if (found != classes.end() && found->second.color) return found->second.color;
  const auto grey = static_cast<std::uint8_t>(code);
  return std::array{grey, grey, grey};
}

bool ClassTable::has_colors() const {
  return std::any_of(classes.begin(), classes.end(), [](const auto& entry) { return entry.second.color.has_value(); });
}

std::string ClassTable::summary() const {
  constexpr std::size_t kShown = 8;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [id, info] : classes) {
    if (shown == kShown) break;
    text += (shown++ == 0 ? "" : ", ") + std::to_string(id) + " " + info.name;
  }
  if (classes.size() > shown) text += ", and " + std::to_string(classes.size() - shown) + " more";
  return text;
}

ClassTable class_table_of(const LayerInfo& layer) {
  ClassTable table;
  const Json metadata = text::json_or_null(layer.metadata_json);
  if (channels::kind_of(layer.channel).shown != channels::Shown::kClasses || !metadata.is_object()) return table;
  table.no_data = code_from(metadata, "no_data_class");
  const auto list = metadata.find("classes");
  if (list == metadata.end() || !list->is_array()) return table;
  for (const Json& entry : *list) {
    if (!entry.is_object()) continue;
    const std::optional<int> id = code_from(entry, "id");
    const std::string name = text_from(entry, "name");
    if (id && !name.empty()) table.classes[*id] = {name, color_from(text_from(entry, "color"))};
  }
  return table;
}

}  // namespace vt::inspect
