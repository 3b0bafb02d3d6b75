// Inputs of any size from one real image: tiles spread over it, stored once, laid out in a pseudo-random
// order.
#pragma once

#include <cstdint>
#include <filesystem>

#include "builder/source/raster_source.h"
#include "store/result.h"
#include "tools/vtbench/inputs/tiled_tiff.h"

namespace vt::bench {

inline constexpr std::uint32_t kPoolTiles = 2000;  // at most, 330 MiB; far more than any cache of a processor holds
// Not the 256 of a store's tiles: each of those then holds pieces of several, so that two are equal only
// where the image itself repeats. Equal ones are stored once.
inline constexpr std::int64_t kPoolTile = 240;
inline constexpr double kPoolBytes = double{kPoolTiles} * kPoolTile * kPoolTile * 3;

// How many tiles such a file stores when they come from `image`: kPoolTiles or all that the image has. kUsage
// when those are fewer than 3 or it is not three or more bands of 8 bits.
[[nodiscard]] Result<std::uint32_t> pool_tiles(const source::RasterInfo& image);

// Writes a file as `spec` says, but with tiles of kPoolTile, at `path`; not synced. Holds one tile in memory
// at a time, and the table.
[[nodiscard]] Result<void> write_pool_image(const std::filesystem::path& path, const source::RasterSource& image, TiledTiffSpec spec);

}  // namespace vt::bench
