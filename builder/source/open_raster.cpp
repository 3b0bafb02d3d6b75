#include "builder/source/files/file_bytes.h"
#include "builder/source/picture/picture_source.h"
#include "builder/source/raster_format.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_source.h"

namespace vt::source {

Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path, const OpenOptions& options) {
  VT_ASSIGN(auto file, FileBytes::open(path, options.files));
  VT_ASSIGN(const RasterFormat format, identify(*file));
  if (format == RasterFormat::kTiff) return open_geotiff(std::move(file), options);
  return open_picture(std::move(file), format, options);
}

}  // namespace vt::source
