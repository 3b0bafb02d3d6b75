// The unit of radiance in a band, of layers that do not name another.
#pragma once

#include <string_view>

namespace vt::channels {

inline constexpr std::string_view kRadianceUnit = "W/(m2 sr)";

}  // namespace vt::channels
