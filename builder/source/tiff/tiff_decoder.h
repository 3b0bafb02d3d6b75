// Cells of one TIFF directory as samples of ours: bits widened, palette expanded, MinIsWhite inverted, alpha
// made straight. A cell is a tile or a strip, or some rows of one that is too large to be held at once:
// uncompressed blocks and compressed strips of any size are cut, only a compressed tile can be refused for
// its size (kMaxCellBytes). Any number of threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "builder/source/cells/cell_store.h"
#include "builder/source/tiff/strip_stream.h"
#include "builder/source/tiff/tiff_handle.h"
#include "builder/source/tiff/tiff_layout.h"
#include "store/result.h"

namespace vt::source {

class TiffDecoder final : public CellDecoder {
 public:
  // `fingerprint`: of the directory's tags that decoding depends on, see decode_fingerprint(). `handle`
  // stands at the directory and is kept for the first reader. `cache`: where the cells will be kept, which
  // decides how large they may be.
  [[nodiscard]] static Result<std::unique_ptr<TiffDecoder>> create(std::unique_ptr<TiffHandle> handle,
                                                                   std::shared_ptr<const FileBytes> file, std::uint16_t directory,
                                                                   TiffLayout layout, const store::ContentHash& fingerprint,
                                                                   const BlockCache& cache);

  [[nodiscard]] const TiffLayout& layout() const { return layout_; }
  [[nodiscard]] const store::ContentHash& fingerprint() const { return fingerprint_; }
  // Bytes that one call holds at most while it runs.
  [[nodiscard]] std::size_t resident_bytes() const;

  [[nodiscard]] const CellGrid& grid() const override { return grid_; }
  [[nodiscard]] Result<Block> decode_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const override;
  // Bytes of samples decoded so far, those that were only passed over included.
  [[nodiscard]] std::uint64_t decoded_bytes() const { return decoded_bytes_.load(std::memory_order_relaxed); }

  // Stored pieces, known again by their hash: whole blocks of compressed files, single cells where rows can
  // be found in the file.
  [[nodiscard]] std::int64_t cells_per_piece() const { return rows_are_seekable_ ? 1 : grid_.cells_per_block(); }
  [[nodiscard]] std::int64_t first_cell_of_piece(std::int64_t cell_y) const { return cell_y - cell_y % cells_per_piece(); }
  // The hash of the piece that begins with this cell. Reads all its stored bytes, a little at a time. A block
  // that was never written has the hash of 16 zeros.
  [[nodiscard]] Result<store::ContentHash> hash_piece(std::int64_t cell_x, std::int64_t cell_y, int plane) const;

  // Samples lie in the file as we want them, but for byte order: rows can be read from any place without a
  // cell around them.
  [[nodiscard]] bool is_direct() const { return direct_; }
  // A rectangle inside one block, tightly packed. Only when is_direct().
  struct BlockRect {
    std::int64_t block_x = 0;
    std::int64_t block_y = 0;
    int plane = 0;
    std::int64_t row = 0;  // row and column count in the block
    std::int64_t rows = 0;
    std::int64_t column = 0;
    std::int64_t columns = 0;
  };
  [[nodiscard]] Result<void> read_direct(const BlockRect& rect, std::span<std::byte> out) const;

 private:
  TiffDecoder(std::shared_ptr<const FileBytes> file, std::uint16_t directory, TiffLayout layout, const store::ContentHash& fingerprint);

  struct BlockPlace {
    std::uint64_t offset = 0;
    std::uint64_t bytes = 0;
    [[nodiscard]] bool is_sparse() const { return bytes == 0; }  // never written: all nodata, or 0
  };
  [[nodiscard]] Result<BlockPlace> block_place(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, int plane) const;
  // kCorrupt: the block's rows cannot be in so few bytes.
  [[nodiscard]] Result<void> check_claim(const BlockPlace& place, std::int64_t block_x, std::int64_t block_y) const;
  // Blocks are read from north to south: while one is worked on, the disk can bring the one below it.
  void expect_below(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, int plane) const;
  [[nodiscard]] std::uint32_t block_index(std::int64_t block_x, std::int64_t block_y, int plane) const;
  [[nodiscard]] tl::unexpected<Error> damaged(std::int64_t block_x, std::int64_t row, const std::string& what) const;

  // Stored bytes of a cell, native byte order.
  [[nodiscard]] Result<Block> stored_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const;
  [[nodiscard]] Result<void> read_uncompressed(const BlockPlace& place, std::int64_t block_x, std::int64_t first_row,
                                               std::int64_t offset_in_block, std::span<std::byte> out) const;
  [[nodiscard]] Result<void> decode_whole(TiffHandle& handle, std::uint32_t index, Block& out) const;
  [[nodiscard]] Result<void> decode_scanlines(TiffHandle& handle, std::int64_t first_row, std::int64_t rows, int plane, Block& out) const;
  [[nodiscard]] Result<void> decode_rgba(TiffHandle& handle, std::int64_t block_x, std::int64_t block_y, Block& out) const;
  [[nodiscard]] Result<void> decode_stream(const StripStream::Strip& strip, std::int64_t first_row, std::int64_t rows, Block& out) const;
  [[nodiscard]] Block as_in_file(Block stored) const;
  void fill_sparse(std::span<std::byte> out) const;
  [[nodiscard]] Block converted(Block stored, std::int64_t rows, int plane) const;
  [[nodiscard]] Block colors_of(const Block& indices, std::size_t count) const;  // of palette indices, with alpha beside them or not

  std::shared_ptr<const FileBytes> file_;
  std::string name_;
  TiffLayout layout_;
  store::ContentHash fingerprint_;
  mutable TiffHandlePool handles_;
  mutable StripStreamPool streams_;
  bool can_stream_ = false;
  bool direct_ = false;
  bool rows_are_seekable_ = false;     // uncompressed: rows are read from their place in the file
  std::int64_t stored_row_bytes_ = 0;  // of one row of a block
  CellGrid grid_;
  mutable std::atomic<std::uint64_t> decoded_bytes_ = 0;
};

}  // namespace vt::source
