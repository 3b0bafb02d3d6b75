// GeoTIFF as a RasterSource. Private to this room: open_raster() is the way in.
#pragma once

#include <memory>

#include "builder/source/file_bytes.h"
#include "builder/source/raster_source.h"

namespace vt::source {

[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_geotiff(std::shared_ptr<const FileBytes> file, const OpenOptions& options);

// Extent and CRS as the caller or a world file give them, for files that say nothing themselves. Used by every kind of source.
[[nodiscard]] Result<void> apply_options(const OpenOptions& options, RasterInfo& info);

}  // namespace vt::source
