// How an image is cut into the cells that are decoded and kept as one: a tile, a strip, or some rows of
// either when it is too large to be held at once. Plain values.
#pragma once

#include <algorithm>
#include <cstdint>

#include "builder/source/cells/block_cache.h"
#include "store/result.h"

namespace vt::source {

struct CellGrid {
  std::int64_t width = 0;  // of the raster
  std::int64_t height = 0;
  std::int64_t block_width = 0;  // of the file's tiles or strips; the last column of tiles sticks out of the raster
  std::int64_t block_height = 0;
  std::int64_t rows_per_cell = 0;  // block_height, or less: the last cell of a block may be lower than the others
  std::int64_t stride = 0;         // bytes from one sample to the next in a decoded cell, all bands of a plane
  int planes = 1;
  // Cells of one block can only be decoded in order, from the block's first.
  bool is_sequential = false;

  [[nodiscard]] std::int64_t blocks_across() const { return (width + block_width - 1) / block_width; }
  [[nodiscard]] std::int64_t blocks_down() const { return (height + block_height - 1) / block_height; }
  [[nodiscard]] std::int64_t cells_per_block() const { return (block_height + rows_per_cell - 1) / rows_per_cell; }
  [[nodiscard]] std::int64_t cells_down() const { return blocks_down() * cells_per_block(); }
  [[nodiscard]] std::int64_t row_bytes() const { return block_width * stride; }  // of a cell
  [[nodiscard]] std::int64_t cell_bytes() const { return row_bytes() * rows_per_cell; }

  // Cells count from the top; those of one block follow each other. In the last block some may lie below the
  // raster, without rows.
  [[nodiscard]] std::int64_t cell_of_row(std::int64_t row) const {
    return row / block_height * cells_per_block() + row % block_height / rows_per_cell;
  }
  [[nodiscard]] std::int64_t first_row(std::int64_t cell_y) const {
    return cell_y / cells_per_block() * block_height + cell_y % cells_per_block() * rows_per_cell;
  }
  [[nodiscard]] std::int64_t cell_rows(std::int64_t cell_y) const {  // inside the raster
    const std::int64_t block_top = cell_y / cells_per_block() * block_height;
    const std::int64_t bottom = std::min(block_top + block_height, height);
    return std::clamp<std::int64_t>(bottom - first_row(cell_y), 0, rows_per_cell);
  }
};

// Who turns stored cells into samples. Any number of threads.
class CellDecoder {
 public:
  virtual ~CellDecoder() = default;
  [[nodiscard]] virtual const CellGrid& grid() const = 0;
  // cell_rows x block_width samples of one plane, bands interleaved. In any order, but see
  // CellGrid::is_sequential for the price.
  [[nodiscard]] virtual Result<Block> decode_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const = 0;
};

}  // namespace vt::source
