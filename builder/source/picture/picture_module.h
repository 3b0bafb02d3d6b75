// The border to the shared library that holds everything made with OpenImageIO. It is loaded when the first
// picture that is not a TIFF is opened: OpenImageIO brings some 260 shared libraries and 120 MiB with it,
// which most runs never need. Both sides are built together, so plain C++ types cross.
#pragma once

#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/picture/picture_format.h"
#include "builder/source/raster_source.h"

namespace vt::source {

// What the library exports, under the name kPictureModuleSymbol.
struct PictureModule {
  Result<std::unique_ptr<RasterSource>> (*open_picture)(std::shared_ptr<const FileBytes> file, const PictureFormat& format,
                                                        const OpenOptions& options);
};
inline constexpr char kPictureModuleSymbol[] = "vt_picture_module";

// The address of something that the library exports; loads it first. kInternal when it is not beside the
// program, where the build puts it. Any thread.
[[nodiscard]] Result<const void*> picture_library_symbol(const char* name);

}  // namespace vt::source

extern "C" __attribute__((visibility("default"))) const vt::source::PictureModule vt_picture_module;
