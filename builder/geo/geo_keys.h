// GeoTIFF keys (OGC 19-008r4) to a Crs and back. Works on the three tags' values alone; whoever owns the TIFF
// fetches and stores them. Every count and offset in the key directory is checked; a damaged key counts as
// absent and is mentioned when it was needed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/geo/vertical_crs.h"

namespace vt::geo {

struct GeoKeyTags {
  std::vector<std::uint16_t> directory;  // tag 34735
  std::vector<double> doubles;           // tag 34736
  std::string ascii;                     // tag 34737, without the closing NUL
};

struct GeoKeyMeaning {
  std::optional<Crs> crs;
  std::string declared;         // what the keys call their CRS, for messages: code, name, method; "" when they declare none
  std::string problem;          // why there is no `crs` although they do
  bool pixel_is_point = false;  // GTRasterTypeGeoKey: tie points name sample centres
  // What the sample values mean where they are heights: VerticalGeoKey, VerticalUnitsGeoKey.
  std::optional<VerticalMeaning> vertical;
};

[[nodiscard]] GeoKeyMeaning crs_from_geo_keys(const GeoKeyTags& tags);
[[nodiscard]] GeoKeyTags geo_keys_from_crs(const Crs& crs);  // always PixelIsArea

}  // namespace vt::geo
