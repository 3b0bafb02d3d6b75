// Every picture that is not a TIFF, by OpenImageIO: PNG, JPEG, JPEG 2000, OpenEXR, HDR and others. Private to this room.
// Made in a shared library of its own, see picture_module.h.
#pragma once

#include <filesystem>
#include <memory>

#include "builder/source/raster_source.h"

namespace vt::source {

[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_picture(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace vt::source
