// How the work on a layer is cut: passes over the pyramid, and blocks in each pass. Arithmetic only; any
// thread.
#pragma once

#include <cstdint>
#include <vector>

#include "store/layer.h"
#include "store/tile_id.h"

namespace vt::pipeline {

// Rows of the finest level that are read and decoded at once; they stay in the second-level cache.
inline constexpr std::int64_t kChunkRows = 32;

// One pass over the pyramid: blocks of the base level, each filtered through `outputs` levels, and the level
// above them kept as carry for the next tier.
struct Tier {
  Level base;
  int outputs = 1;
  bool has_carry = false;
  TexelRect data;                 // of the base level
  std::int64_t block_texels = 0;  // along one edge of a block, base level
  std::int64_t first_column = 0;  // of blocks
  std::int64_t first_row = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;

  [[nodiscard]] std::int64_t blocks() const { return columns * rows; }
  // Block `index` counts along rows, north to south. Unclipped.
  [[nodiscard]] TexelRect block(std::int64_t index) const;
  // The tile of the carry level that a block is responsible for.
  [[nodiscard]] TileId carry_tile(std::int64_t index) const;
  // Which one lies in a column and row of blocks.
  [[nodiscard]] std::int64_t index_of(std::int64_t column, std::int64_t row) const {
    return (row - first_row) * columns + (column - first_column);
  }
  // The block that is responsible for a carry tile.
  [[nodiscard]] std::int64_t block_of_carry(TileId tile) const { return index_of(tile.x, tile.y); }
};

// A block spans 2^levels tiles along an edge, so one carry tile each.
[[nodiscard]] std::vector<Tier> plan_tiers(const LayerInfo& info, int levels);

}  // namespace vt::pipeline
