#include <algorithm>
#include <array>

#include "builder/source/file_bytes.h"
#include "builder/source/geotiff_source.h"
#include "builder/source/picture_source.h"
#include "builder/source/raster_source.h"

namespace vt::source {

Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path, const OpenOptions& options) {
  VT_ASSIGN(auto file, FileBytes::open(path, options.files));
  std::array<std::byte, 4> magic{};
  VT_ASSIGN(const std::size_t got, file->read_some(0, magic));
  const auto starts_with = [&](std::array<int, 4> bytes) {
    return got == 4 && std::ranges::equal(magic, bytes, [](std::byte a, int b) { return std::to_integer<int>(a) == b; });
  };
  // TIFF and BigTIFF, either byte order.
  if (starts_with({'I', 'I', 42, 0}) || starts_with({'M', 'M', 0, 42}) || starts_with({'I', 'I', 43, 0}) ||
      starts_with({'M', 'M', 0, 43})) {
    return open_geotiff(std::move(file), options);
  }
  return open_picture(std::move(file), options);
}

}  // namespace vt::source
