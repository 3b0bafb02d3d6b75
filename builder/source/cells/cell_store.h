// Decoded cells of one image on their way to the readers: kept in the shared cache, or in a scratch file
// where the cache would make them be decoded again and again. Any number of threads.
//
// Blocks of texels are read one beside the other, each from its top to its bottom, by several threads. Tiles
// and narrow strips serve one or two such blocks at about the same time, so the cache is enough. Two kinds of
// cells go to the scratch file, when there is one:
//   - rows that can only be decoded from the top of a strip or picture: every further block would start over;
//   - strips wider than kOneBlockColumns of an image that does not fit into half of the cache: every block in a row of blocks would decode
//     all of them again.
// Strips and pictures that are small beside the cache (largest_cell_bytes()) are one cell, decoded whole, and
// belong to neither kind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "builder/source/cells/block_cache.h"
#include "builder/source/cells/cell_grid.h"
#include "builder/source/cells/scratch_file.h"
#include "builder/source/cells/spilled_rows.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

// Up to this size a strip or a picture is worth keeping decoded as one cell: an eighth of the cache, so that
// several threads and sources find room, but never more than 16 MiB.
[[nodiscard]] std::int64_t largest_cell_bytes(const BlockCache& cache);
// Larger ones are cut into cells of this many rows of `row_bytes`.
[[nodiscard]] std::int64_t rows_of_cut_cell(const BlockCache& cache, std::int64_t row_bytes);

class CellStore {
 public:
  // A block of texels with its apron, which the builder reads at one time: 4096 texels and kernels at both
  // sides.
  static constexpr std::int64_t kOneBlockColumns = 4608;

  // `decoder` outlives this. `scratch` may be null.
  CellStore(const CellDecoder& decoder, std::shared_ptr<BlockCache> cache, const std::shared_ptr<ScratchFile>& scratch);

  // Calls use(samples at the part's first column, bytes from row to row, part) for parts that cover the
  // window of one plane. The part counts in the raster. `may_skip_cache`: cells that lie in the window whole
  // will hardly be asked for again.
  template <class Use>
  [[nodiscard]] Result<void> visit(int plane, bool may_skip_cache, const Window& window, const Use& use) const;

  void release_rows_before(std::int64_t row) const;
  [[nodiscard]] bool spills() const { return !spilled_.empty(); }
  [[nodiscard]] BlockCache& cache() const { return *cache_; }
  [[nodiscard]] BlockKey key(std::int64_t cell_x, std::int64_t cell_y, int plane) const {
    return {.source = id_, .block = static_cast<std::uint64_t>((plane * grid_.cells_down() + cell_y) * grid_.blocks_across() + cell_x)};
  }
  // Bytes that one visit holds beyond the cache and what the decoder itself takes.
  [[nodiscard]] std::size_t resident_bytes() const { return spills() ? kSpilledAtOnce : 0; }

 private:
  static constexpr std::size_t kSpilledAtOnce = std::size_t{1} << 20;

  [[nodiscard]] Result<BlockPtr> cell(std::int64_t cell_x, std::int64_t cell_y, int plane, bool is_wanted_whole) const;
  template <class Use>
  [[nodiscard]] Result<void> visit_spilled(int plane, const Window& window, const Use& use) const;
  template <class Use>
  [[nodiscard]] Result<void> visit_cells(int plane, bool may_skip_cache, const Window& window, const Use& use) const;

  const CellDecoder& decoder_;
  const CellGrid& grid_;
  std::shared_ptr<BlockCache> cache_;
  std::uint64_t id_;                                   // in the cache
  std::vector<std::unique_ptr<SpilledRows>> spilled_;  // one a plane, or none
};

template <class Use>
Result<void> CellStore::visit(int plane, bool may_skip_cache, const Window& window, const Use& use) const {
  return spills() ? visit_spilled(plane, window, use) : visit_cells(plane, may_skip_cache, window, use);
}

template <class Use>
Result<void> CellStore::visit_spilled(int plane, const Window& window, const Use& use) const {
  const std::int64_t row_bytes = window.width * grid_.stride;
  const std::int64_t rows_at_once = std::clamp<std::int64_t>(static_cast<std::int64_t>(kSpilledAtOnce) / row_bytes, 1, window.height);
  Block buffer;
  for (std::int64_t row = window.y; row < window.y + window.height; row += rows_at_once) {
    const Window part{.x = window.x, .y = row, .width = window.width, .height = std::min(rows_at_once, window.y + window.height - row)};
    buffer.resize(static_cast<std::size_t>(row_bytes * part.height));
    VT_CHECK(spilled_[static_cast<std::size_t>(plane)]->read({.row = part.y, .rows = part.height, .column = part.x, .columns = part.width},
                                                             buffer));
    use(buffer.data(), row_bytes, part);
  }
  return {};
}

template <class Use>
Result<void> CellStore::visit_cells(int plane, bool may_skip_cache, const Window& window, const Use& use) const {
  const std::int64_t right = window.x + window.width;
  const std::int64_t bottom = window.y + window.height;
  const std::int64_t last_y = grid_.cell_of_row(bottom - 1);
  const std::int64_t last_x = (right - 1) / grid_.block_width;
  for (std::int64_t cell_y = grid_.cell_of_row(window.y); cell_y <= last_y; ++cell_y) {
    const std::int64_t cell_top = grid_.first_row(cell_y);
    const std::int64_t cell_rows = grid_.cell_rows(cell_y);
    for (std::int64_t cell_x = window.x / grid_.block_width; cell_x <= last_x; ++cell_x) {
      const std::int64_t cell_left = cell_x * grid_.block_width;
      Window part{.x = std::max(window.x, cell_left), .y = std::max(window.y, cell_top), .width = 0, .height = 0};
      part.width = std::min({right, cell_left + grid_.block_width, grid_.width}) - part.x;
      part.height = std::min(bottom, cell_top + cell_rows) - part.y;
      const bool whole = may_skip_cache && part.height == cell_rows && part.width == std::min(grid_.block_width, grid_.width - cell_left);
      VT_ASSIGN(const BlockPtr block, cell(cell_x, cell_y, plane, whole));
      use(block->data() + (part.y - cell_top) * grid_.row_bytes() + (part.x - cell_left) * grid_.stride, grid_.row_bytes(), part);
    }
  }
  return {};
}

}  // namespace vt::source
