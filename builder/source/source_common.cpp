#include "builder/source/source_common.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "builder/source/metadata/world_file.h"

namespace vt::source {
namespace {

template <class T>
void straighten(std::span<std::byte> bytes, int bands, int alpha_band, double max_code) {
  const std::size_t pixel = sizeof(T) * static_cast<std::size_t>(bands);
  for (std::size_t at = 0; at + pixel <= bytes.size(); at += pixel) {
    const auto alpha = static_cast<double>(load<T>(bytes.data() + at + sizeof(T) * static_cast<std::size_t>(alpha_band)));
    for (int band = 0; band < bands; ++band) {
      if (band == alpha_band) continue;
      std::byte* place = bytes.data() + at + sizeof(T) * static_cast<std::size_t>(band);
      const auto value = static_cast<double>(load<T>(place));
      if constexpr (std::is_floating_point_v<T>) {
        if (alpha > 0.0) store(place, static_cast<T>(value / alpha));
      } else {
        store(place, alpha > 0.0 ? static_cast<T>(std::min(max_code, std::floor(value * max_code / alpha + 0.5))) : T{0});
      }
    }
  }
}

// Corners of the raster lie within half a sample of each other.
bool is_same_place(const geo::GeoTransform& a, const geo::GeoTransform& b, const RasterInfo& info) {
  const auto width = static_cast<double>(info.width);
  const auto height = static_cast<double>(info.height);
  const double reach_x = 0.5 * (std::abs(a.x_column) + std::abs(a.x_row));
  const double reach_y = 0.5 * (std::abs(a.y_column) + std::abs(a.y_row));
  for (const Point2 corner : {Point2{0.0, 0.0}, Point2{width, 0.0}, Point2{0.0, height}, Point2{width, height}}) {
    const Point2 p = a.crs_from_raster(corner);
    const Point2 q = b.crs_from_raster(corner);
    if (!(std::abs(p.x - q.x) <= reach_x && std::abs(p.y - q.y) <= reach_y)) return false;
  }
  return true;
}

}  // namespace

void straighten_alpha(SampleType type, std::span<std::byte> samples, int bands, int alpha_band, double max_code) {
  visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
    straighten<T>(samples, bands, alpha_band, std::is_unsigned_v<T> ? max_code : full_scale(type));
  });
}

std::shared_ptr<BlockCache> cache_of(const OpenOptions& options) {
  return options.cache ? options.cache : std::make_shared<BlockCache>(options.cache_bytes);
}

Result<void> apply_options(const OpenOptions& options, RasterInfo& info) {
  info.crs = options.crs ? options.crs : info.declared_crs;
  if (!info.crs && info.declared_crs_text.empty()) info.crs = options.fallback_crs;
  // What the file says, or a world file beside it.
  const Result<std::optional<geo::GeoTransform>> own =
      info.has_transform ? Result<std::optional<geo::GeoTransform>>(info.transform) : read_world_file(info.path);
  if (!options.extent) {
    if (!own) return tl::unexpected(own.error());
    if (*own) info.transform = **own;
    info.has_transform = own->has_value();
    return {};
  }
  Area area = *options.extent;
  const std::optional<double> turn = info.crs ? info.crs->turn() : std::nullopt;
  if (turn && area.west > area.east) area.east += *turn;  // across the antimeridian
  const bool sane = std::isfinite(area.west) && std::isfinite(area.south) && area.west < area.east && area.south < area.north &&
                    std::isfinite(area.east) && std::isfinite(area.north);
  if (!sane) {
    return fail(ErrorCode::kUsage, fmt::format("{}: extent west {} south {} east {} north {}: wanted west < east and south < north",
                                               info.path.string(), area.west, area.south, area.east, area.north));
  }
  info.transform = geo::GeoTransform{.x0 = area.west,
                                     .x_column = (area.east - area.west) / static_cast<double>(info.width),
                                     .x_row = 0.0,
                                     .y0 = area.north,
                                     .y_column = 0.0,
                                     .y_row = -(area.north - area.south) / static_cast<double>(info.height)};
  info.has_transform = true;
  if (!info.place_problem.empty() || !own || (*own && !is_same_place(**own, info.transform, info)))
    info.unused.push_back({.what = "a place of its own", .instead = "the extent that is given counts"});
  return {};
}

Result<void> check_window(const RasterInfo& info, const Window& window, std::span<const int> bands) {
  const bool inside = window.x >= 0 && window.y >= 0 && window.width > 0 && window.height > 0 && window.width <= info.width - window.x &&
                      window.height <= info.height - window.y;
  if (!inside) {
    return fail(ErrorCode::kUsage, fmt::format("{}: window {},{} {}x{} is not inside the raster of {}x{}", info.path.string(), window.x,
                                               window.y, window.width, window.height, info.width, info.height));
  }
  for (const int band : bands) {
    if (band != kLeaveAlone && (band < 0 || band >= info.bands)) {
      return fail(ErrorCode::kUsage, fmt::format("{}: band {} of {}", info.path.string(), band, info.bands));
    }
  }
  return {};
}

Result<void> check_request(const RasterInfo& info, const Window& window, std::span<const int> bands, std::span<const std::byte> out,
                           std::size_t row_pitch_bytes) {
  VT_CHECK(check_window(info, window, bands));
  const std::size_t row_bytes = static_cast<std::size_t>(window.width) * bands.size() * sample_bytes(info.sample_type);
  if (row_pitch_bytes < row_bytes || out.size() < row_pitch_bytes * static_cast<std::size_t>(window.height - 1) + row_bytes) {
    return fail(ErrorCode::kUsage, fmt::format("{}: the output buffer is too small for the window", info.path.string()));
  }
  return {};
}

}  // namespace vt::source
