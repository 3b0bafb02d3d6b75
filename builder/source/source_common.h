// What every kind of source does alike. Private to this folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "builder/source/cells/block_cache.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

// Largest decoded piece that any source holds at once.
inline constexpr std::int64_t kMaxCellBytes = std::int64_t{256} << 20;

// One sample at any place, aligned or not.
template <class T>
[[nodiscard]] T load(const std::byte* place) {
  T value;
  std::memcpy(&value, place, sizeof value);
  return value;
}
template <class T>
void store(std::byte* place, T value) {
  std::memcpy(place, &value, sizeof value);
}

// The cache that the caller gave, or a new one.
[[nodiscard]] std::shared_ptr<BlockCache> cache_of(const OpenOptions& options);

// Extent, CRS and nodata as the caller or a world file give them.
[[nodiscard]] Result<void> apply_options(const OpenOptions& options, RasterInfo& info);

// kUsage when window or bands do not fit the raster.
[[nodiscard]] Result<void> check_window(const RasterInfo& info, const Window& window, std::span<const int> bands);
// kUsage when the arguments of RasterSource::read() do not fit the raster or the buffer.
[[nodiscard]] Result<void> check_request(const RasterInfo& info, const Window& window, std::span<const int> bands,
                                         std::span<const std::byte> out, std::size_t row_pitch_bytes);

// Premultiplied colours to straight ones, in place: interleaved samples of `bands` bands. Rounded to the
// nearest code; without alpha there is no colour to recover and integers become 0. `max_code` is full
// coverage; 1 for floating point.
void straighten_alpha(SampleType type, std::span<std::byte> samples, int bands, int alpha_band, double max_code);

}  // namespace vt::source
