// Numbers in sentences for people. Any thread.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace vt::text {

// The shortest of so many significant digits, from 1 to 17: "0.3048006", "1.5e-09".
[[nodiscard]] inline std::string number_text(double value, int digits = 9) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

}  // namespace vt::text
