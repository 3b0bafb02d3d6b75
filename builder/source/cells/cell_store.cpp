#include "builder/source/cells/cell_store.h"

#include <algorithm>

namespace vt::source {
namespace {

bool must_spill(const CellGrid& grid, const BlockCache& cache) {
  if (grid.blocks_across() > 1) return false;  // tiles
  if (grid.is_sequential && grid.cells_per_block() > 1) return true;
  if (grid.width <= CellStore::kOneBlockColumns) return false;
  const auto half_cache = static_cast<std::int64_t>(std::min<std::size_t>(cache.budget_bytes() / 2, INT64_MAX));
  return grid.row_bytes() * grid.planes > half_cache / grid.height;
}

}  // namespace

std::int64_t largest_cell_bytes(const BlockCache& cache) {
  constexpr std::size_t kLeast = std::size_t{1} << 20;
  constexpr std::size_t kMost = std::size_t{16} << 20;
  return static_cast<std::int64_t>(std::clamp(cache.budget_bytes() / 8, kLeast, kMost));
}

std::int64_t rows_of_cut_cell(const BlockCache& cache, std::int64_t row_bytes) {
  constexpr std::int64_t kCutCellBytes = std::int64_t{4} << 20;
  return std::max<std::int64_t>(1, std::min(kCutCellBytes, largest_cell_bytes(cache)) / row_bytes);
}

CellStore::CellStore(const CellDecoder& decoder, std::shared_ptr<BlockCache> cache, const std::shared_ptr<ScratchFile>& scratch)
    : decoder_(decoder), grid_(decoder.grid()), cache_(std::move(cache)), id_(cache_->add_source()) {
  if (!scratch || !must_spill(grid_, *cache_)) return;
  for (int plane = 0; plane < grid_.planes; ++plane) spilled_.push_back(std::make_unique<SpilledRows>(decoder_, plane, scratch));
}

Result<BlockPtr> CellStore::cell(std::int64_t cell_x, std::int64_t cell_y, int plane, bool is_wanted_whole) const {
  const auto decode = [&] { return decoder_.decode_cell(cell_x, cell_y, plane); };
  if (!is_wanted_whole) return cache_->get(key(cell_x, cell_y, plane), decode);
  if (BlockPtr block = cache_->peek(key(cell_x, cell_y, plane))) return block;
  VT_ASSIGN(Block decoded, decode());
  return std::make_shared<const Block>(std::move(decoded));
}

void CellStore::release_rows_before(std::int64_t row) const {
  for (const auto& plane : spilled_) plane->release_rows_before(row);
}

}  // namespace vt::source
