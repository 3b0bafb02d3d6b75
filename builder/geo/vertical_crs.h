// What the GeoKeys say about heights: their unit, and whether they count upward. The datum is named, not
// converted. Constant data, any thread.
#pragma once

#include <optional>
#include <string>

namespace vt::geo {

struct VerticalMeaning {
  std::string name;                       // "EPSG:5703", or the file's own words; "" when it does not say
  std::optional<double> metres_per_unit;  // of a height; empty when it does not say
  bool counts_down = false;               // numbers are depths
  std::string unit_problem;               // the unit in words, where it is one that is not known, or the file says two
};

// The heights of a vertical CRS, by its EPSG code as in VerticalGeoKey (4096). Codes that the registry's list
// of other units and of depths does not have are heights in metres.
[[nodiscard]] VerticalMeaning vertical_from_epsg(int code);

}  // namespace vt::geo
