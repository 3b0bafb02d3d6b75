// Writes BigTIFFs of uncompressed RGB8 tiles whose table may name one stored tile many times: a legal file
// that is as large as one likes in texels and small on the disk. For measuring, where the size must be real
// and the pictures need not; nothing else should use it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "store/io/file.h"
#include "store/result.h"

namespace vt::bench {

struct TiledTiffSpec {
  std::int64_t width = 256;  // texels
  std::int64_t height = 256;
  std::int64_t tile = 256;                     // texels along an edge, a multiple of 16; the last ones stick out
  std::optional<geo::GeoTransform> transform;  // north up
  std::optional<geo::Crs> crs;

  [[nodiscard]] std::int64_t columns() const { return (width + tile - 1) / tile; }
  [[nodiscard]] std::int64_t rows() const { return (height + tile - 1) / tile; }
};

class TiledTiffWriter {
 public:
  [[nodiscard]] static Result<TiledTiffWriter> create(const std::filesystem::path& path, const TiledTiffSpec& spec);

  // `rgb` is tile * tile * 3 bytes, rows north to south. Stored tiles are counted from 0.
  [[nodiscard]] Result<void> add_tile(std::span<const std::byte> rgb);
  // `table` has columns() * rows() entries, row by row from the north-west: which stored tile lies there.
  // Nothing is synced.
  [[nodiscard]] Result<void> finish(std::span<const std::uint32_t> table);

 private:
  TiledTiffWriter(store::File file, TiledTiffSpec spec) : file_(std::move(file)), spec_(std::move(spec)) {}
  [[nodiscard]] std::uint64_t tile_bytes() const { return static_cast<std::uint64_t>(spec_.tile * spec_.tile * 3); }

  store::File file_;
  TiledTiffSpec spec_;
  std::uint32_t stored_ = 0;
};

// A table of columns * rows entries below `stored` (at least 3), pseudo-random and always the same; no tile
// is the one to its west or north.
[[nodiscard]] std::vector<std::uint32_t> scattered_tiles(std::int64_t columns, std::int64_t rows, std::uint32_t stored);

}  // namespace vt::bench
