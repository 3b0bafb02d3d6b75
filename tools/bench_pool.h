// Inputs of any size from one real image: tiles spread over it, stored once, laid out in a pseudo-random order.
#pragma once

#include <cstdint>
#include <filesystem>

#include "builder/source/raster_source.h"
#include "store/result.h"
#include "tools/bench_tiled_tiff.h"

namespace vt::bench {

inline constexpr std::uint32_t kPoolTiles = 2000;  // at most, 375 MiB; far more than any cache of a processor holds

// How many tiles such a file stores when they come from `image`: kPoolTiles or all that the image has. kUsage when those are fewer than 3
// or it is not three or more bands of 8 bits.
[[nodiscard]] Result<std::uint32_t> pool_tiles(const source::RasterInfo& image);

// Writes a file of columns * rows tiles at `path`, in the page cache and not synced. Holds one tile in memory at a time, and the table.
[[nodiscard]] Result<void> write_pool_image(const std::filesystem::path& path, const source::RasterSource& image,
                                            const TiledTiffSpec& spec);

}  // namespace vt::bench
