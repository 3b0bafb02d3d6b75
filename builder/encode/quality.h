// How much work a block encoder may spend. Every level gives the same bytes on every CPU; a higher one takes
// longer and keeps a smaller squared error over an image, up to what the encoder's own header promises.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vt::encode {

enum class Quality : std::uint8_t {
  kFast,    // one pass: end points straight from the extremes of the block; for previews
  kNormal,  // refined by least squares; the default of every build
  kBest,    // a search over end points that only data made once and read often is worth
};

inline constexpr std::array<std::string_view, 3> kQualityNames = {"fast", "normal", "best"};
[[nodiscard]] constexpr std::string_view quality_name(Quality quality) { return kQualityNames[static_cast<std::size_t>(quality)]; }
[[nodiscard]] constexpr std::optional<Quality> quality_from_name(std::string_view name) {
  for (std::size_t i = 0; i < kQualityNames.size(); ++i)
    if (kQualityNames[i] == name) return static_cast<Quality>(i);
  return std::nullopt;
}

}  // namespace vt::encode
