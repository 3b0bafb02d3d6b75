// Every picture that is not a TIFF, by OpenImageIO: PNG, JPEG, JPEG 2000, OpenEXR, Radiance HDR, PNM, and no other format, whatever
// OpenImageIO could read besides. Private to this folder.
// Made in a shared library of its own, see picture_module.h.
#pragma once

#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_format.h"
#include "builder/source/raster_source.h"

namespace vt::source {

[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_picture(std::shared_ptr<const FileBytes> file, RasterFormat format,
                                                                 const OpenOptions& options);

}  // namespace vt::source
