// JSON that came from a file: a scene, a table, the metadata of a store. The one place where it is parsed.
// What is nested deeper, or longer, than any honest text is refused before a tree is made of it: the tree
// would be walked, copied and printed by recursion. Any thread.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>

#include "store/result.h"

namespace vt::text {

inline constexpr int kMaxJsonDepth = 64;                            // lists and objects inside each other
inline constexpr std::size_t kMaxJsonBytes = std::size_t{1} << 28;  // about a million sources in a scene

// kInvalidData: "is not JSON: line 3, column 7: ...". A number that no double holds (1e999) is an error as
// well.
[[nodiscard]] Result<nlohmann::json> parse_json(std::string_view text);
// Members keep the order of the text.
[[nodiscard]] Result<nlohmann::ordered_json> parse_ordered_json(std::string_view text);

// For metadata that only help: null where parse_json() would fail.
[[nodiscard]] nlohmann::ordered_json json_or_null(std::string_view text);

}  // namespace vt::text
