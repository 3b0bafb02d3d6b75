#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/source/file_bytes.h"
#include "builder/source/geotiff_source.h"
#include "builder/source/picture_source.h"
#include "builder/source/raster_source.h"
#include "builder/source/world_file.h"

namespace vt::source {

Result<void> apply_options(const OpenOptions& options, RasterInfo& info) {
  if (options.nodata) info.nodata = options.nodata;
  if (options.crs) {
    info.crs = options.crs;
    info.crs_problem.clear();
  }
  if (options.extent) {
    const Area& area = *options.extent;
    const bool sane = std::isfinite(area.west) && std::isfinite(area.south) && area.west < area.east && area.south < area.north &&
                      std::isfinite(area.east) && std::isfinite(area.north);
    if (!sane) {
      return fail(ErrorCode::kUsage, fmt::format("{}: extent west {} south {} east {} north {}: wanted west < east and south < north", info.path.string(),
                                                 area.west, area.south, area.east, area.north));
    }
    info.transform = geo::GeoTransform{.x0 = area.west,
                                       .x_column = (area.east - area.west) / static_cast<double>(info.width),
                                       .x_row = 0.0,
                                       .y0 = area.north,
                                       .y_column = 0.0,
                                       .y_row = -(area.north - area.south) / static_cast<double>(info.height)};
    info.has_transform = true;
  } else if (!info.has_transform) {
    VT_ASSIGN(const auto transform, read_world_file(info.path));
    if (transform) {
      info.transform = *transform;
      info.has_transform = true;
    }
  }
  return {};
}

Result<std::unique_ptr<RasterSource>> open_raster(const std::filesystem::path& path, const OpenOptions& options) {
  VT_ASSIGN(auto file, FileBytes::open(path));
  std::array<std::byte, 4> magic{};
  VT_ASSIGN(const std::size_t got, file->read_some(0, magic));
  const auto starts_with = [&](std::array<int, 4> bytes) {
    return got == 4 && std::ranges::equal(magic, bytes, [](std::byte a, int b) { return std::to_integer<int>(a) == b; });
  };
  // TIFF and BigTIFF, either byte order.
  if (starts_with({'I', 'I', 42, 0}) || starts_with({'M', 'M', 0, 42}) || starts_with({'I', 'I', 43, 0}) || starts_with({'M', 'M', 0, 43})) {
    return open_geotiff(std::move(file), options);
  }
  return open_picture(path, options);
}

}  // namespace vt::source
