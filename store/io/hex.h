// Numbers as hexadecimal digits. Pure functions, any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vt::store {

inline constexpr std::string_view kHexDigits = "0123456789abcdef";

// The lowest 4 * `digits` bits, the most significant digit first.
[[nodiscard]] inline std::string hex(std::uint64_t number, int digits) {
  std::string text;
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) text += kHexDigits[number >> shift & 15U];
  return text;
}

}  // namespace vt::store
