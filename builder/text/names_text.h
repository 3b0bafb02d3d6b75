// Names in a row, for messages and help. Pure functions, any thread.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace vt::text {

// "a, b, c" of what `name` gives for each item: a member or a function; without one the items are the names.
template <class Items, class Name = std::identity>
[[nodiscard]] std::string names_text(const Items& items, Name name = {}) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + std::string(std::string_view(std::invoke(name, item)));
  return text;
}

}  // namespace vt::text
