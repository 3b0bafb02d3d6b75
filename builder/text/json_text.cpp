#include "builder/text/json_text.h"

#include <algorithm>
#include <optional>
#include <string>

namespace vt::text {
namespace {

// "line 3, column 7" of a byte.
std::string place_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return "line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) + ", column " +
         std::to_string(before.size() - line_start + 1);
}

// The first bracket that opens a list or an object too deep inside others. Looks at brackets outside strings
// alone: a text that is no JSON is for the parser to find.
std::optional<std::size_t> first_too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '}' || c == ']') --depth;
    if ((c == '{' || c == '[') && ++depth > kMaxJsonDepth) return i;
  }
  return std::nullopt;
}

// The library's messages begin with its own name for the kind of error, and a place if they have one.
std::string without_prefix(std::string message) {
  if (const std::size_t end = message.find("] "); message.starts_with("[json") && end != std::string::npos) message.erase(0, end + 2);
  if (const std::size_t end = message.find(": "); message.starts_with("parse error at") && end != std::string::npos)
    message.erase(0, end + 2);
  return message;
}

template <class Json>
Result<Json> parse(std::string_view text) {
  if (text.size() > kMaxJsonBytes)
    return fail(ErrorCode::kInvalidData, "is not read as JSON: it has " + std::to_string(text.size()) + " bytes, " +
                                             std::to_string(kMaxJsonBytes) + " are the most");
  if (const auto place = first_too_deep(text))
    return fail(ErrorCode::kInvalidData, "is not read as JSON: " + place_of(text, *place) + ": lists and objects lie more than " +
                                             std::to_string(kMaxJsonDepth) + " deep inside each other");
  try {
    return Json::parse(text);
  } catch (const typename Json::parse_error& error) {
    return fail(ErrorCode::kInvalidData,
                "is not JSON: " + place_of(text, error.byte == 0 ? 0 : error.byte - 1) + ": " + without_prefix(error.what()));
  } catch (const typename Json::exception& error) {
    return fail(ErrorCode::kInvalidData, "is not JSON: " + without_prefix(error.what()));
  }
}

}  // namespace

Result<nlohmann::json> parse_json(std::string_view text) { return parse<nlohmann::json>(text); }
Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text) { return parse<nlohmann::ordered_json>(text); }

nlohmann::ordered_json json_or_null(std::string_view text) {
  auto json = parse_ordered_json(text);
  return json ? std::move(*json) : nlohmann::ordered_json(nullptr);
}

}  // namespace vt::text
