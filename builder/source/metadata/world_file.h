// Six numbers beside a picture (.tfw, .jgw, .wld) that place its sample centres.
#pragma once

#include <filesystem>
#include <optional>

#include "builder/geo/geo_transform.h"
#include "store/result.h"

namespace vt::source {

// nullopt: there is none beside `raster`. kInvalidData: there is one that makes no sense.
[[nodiscard]] Result<std::optional<geo::GeoTransform>> read_world_file(const std::filesystem::path& raster);

}  // namespace vt::source
