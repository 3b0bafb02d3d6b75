// Units of length and of angle as files and people write them. Constant data, any thread.
#pragma once

#include <optional>
#include <string_view>

namespace vt::channels {

// Metres of one unit: "m", "metre", "ft", "foot", "US survey foot", "us-ft", "cm", ... in either case, or a
// number of metres like "0.3048 m". Empty for what is no length that we know.
[[nodiscard]] std::optional<double> metres_of_unit(std::string_view unit);

// Radians of one unit: "rad", "degree", "mrad", ... in either case. Empty for what is no angle that we know.
[[nodiscard]] std::optional<double> radians_of_unit(std::string_view unit);

}  // namespace vt::channels
