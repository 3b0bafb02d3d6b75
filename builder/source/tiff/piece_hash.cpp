#include "builder/source/tiff/piece_hash.h"

namespace vt::source {

Result<void> hash_pieces(const TiffDecoder& decoder, const CellStore& cells, int plane, const Window& window,
                         store::ContentHasher& content) {
  const CellGrid& grid = decoder.grid();
  const std::int64_t last_x = (window.x + window.width - 1) / grid.block_width;
  const std::int64_t first_cell = grid.cell_of_row(window.y);
  const std::int64_t last_cell = grid.cell_of_row(window.y + window.height - 1);
  for (std::int64_t cell_y = decoder.first_cell_of_piece(first_cell); cell_y <= last_cell; cell_y += decoder.cells_per_piece()) {
    for (std::int64_t cell_x = window.x / grid.block_width; cell_x <= last_x; ++cell_x) {
      VT_ASSIGN(const store::ContentHash hash,
                cells.cache().hash(cells.key(cell_x, cell_y, plane), [&] { return decoder.hash_piece(cell_x, cell_y, plane); }));
      content.add(hash.bytes);
    }
  }
  return {};
}

}  // namespace vt::source
