// Every picture that is not a TIFF, by OpenImageIO: of the formats in picture_format.h, and no other,
// whatever OpenImageIO could read besides. Made in a shared library of its own, see picture_module.h.
#pragma once

#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/picture/picture_format.h"
#include "builder/source/raster_source.h"

namespace vt::source {

[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_picture(std::shared_ptr<const FileBytes> file, const PictureFormat& format,
                                                                 const OpenOptions& options);

}  // namespace vt::source
