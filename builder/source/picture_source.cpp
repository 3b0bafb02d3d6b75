#include "builder/source/picture_source.h"

#include <fmt/format.h>

namespace vt::source {

Result<std::unique_ptr<RasterSource>> open_picture(const std::filesystem::path& path, const OpenOptions&) {
  return fail(ErrorCode::kUnsupported, fmt::format("{}: not a TIFF", path.string()));
}

}  // namespace vt::source
