// What an ICC profile says of colours, as far as it matters whether they are sRGB. Pure; any thread.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace vt::source {

struct ColorProfile {
  std::string description;  // its name, printable; "" when it has none
  bool is_srgb = false;  // its colorants and curves are those of sRGB, so that decoding as sRGB is right; of grey profiles the curve alone
};

// Damaged profiles are not sRGB and have no name.
[[nodiscard]] ColorProfile read_color_profile(std::span<const std::byte> profile);

}  // namespace vt::source
