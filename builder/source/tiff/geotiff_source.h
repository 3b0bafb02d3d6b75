// GeoTIFF as a RasterSource. open_raster() is the way in.
#pragma once

#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_source.h"

namespace vt::source {

[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_geotiff(std::shared_ptr<const FileBytes> file, const OpenOptions& options);

}  // namespace vt::source
