// What one TIFF directory says about its place on the Earth: GeoKeys, and the tags that map samples to
// coordinates. Private to this folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "builder/geo/geo_keys.h"
#include "builder/geo/geo_transform.h"
#include "builder/source/metadata/tiff_tags.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

struct TiffPlace {
  std::optional<geo::GeoTransform> transform;
  std::string problem;  // why there is none although the tags try to give one, and what to do
  std::vector<UnusedFact> unused;
  geo::GeoKeyMeaning keys;
  // The values, where they are heights, are offset + scale * sample: from the third numbers of pixel scale
  // and tie point.
  std::optional<double> height_scale;
  std::optional<double> height_offset;
};

// kIo, kInvalidData: as of TiffTags.
[[nodiscard]] Result<TiffPlace> read_tiff_place(const TiffTags& tags);

}  // namespace vt::source
