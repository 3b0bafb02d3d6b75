// Rows of one plane of an image that are decoded once and then read from a scratch file: for cells that can
// only be decoded in order, or that are wider than what one reader wants of them. Leaves the decoding to a
// CellDecoder. Any number of threads.
//
// Sequential cells are decoded by one thread at a time, forward, as far as they are asked for. Rows that were
// released are decoded again when somebody wants them after all; nothing but time depends on the hint.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <vector>

#include "builder/source/cells/cell_grid.h"
#include "builder/source/cells/scratch_file.h"
#include "store/result.h"

namespace vt::source {

class SpilledRows {
 public:
  // Cells as wide as the raster. `decoder` outlives this.
  SpilledRows(const CellDecoder& decoder, int plane, std::shared_ptr<ScratchFile> scratch);
  SpilledRows(const SpilledRows&) = delete;
  SpilledRows& operator=(const SpilledRows&) = delete;
  ~SpilledRows();

  struct Rect {
    std::int64_t row = 0;
    std::int64_t rows = 0;
    std::int64_t column = 0;
    std::int64_t columns = 0;
  };
  // Tightly packed, exactly rows * columns * stride bytes.
  [[nodiscard]] Result<void> read(const Rect& rect, std::span<std::byte> out);
  // Gives scratch space back, but for a few rows that readers with an apron may still want.
  void release_rows_before(std::int64_t row);

  // Rows that stay before the row of the hint: more than any resampling kernel reaches, for warps that bulge
  // a little.
  static constexpr std::int64_t kKeptRows = 256;

 private:
  enum class State : std::uint8_t { kNew, kDecoding, kPresent, kReleased };

  [[nodiscard]] Result<void> prepare();  // once
  [[nodiscard]] Result<void> make(std::int64_t cell);
  [[nodiscard]] Result<void> make_in_order(std::int64_t cell);
  [[nodiscard]] Result<void> decode_and_keep(std::int64_t cell);  // its state is kDecoding
  [[nodiscard]] Result<void> read_present(const Rect& rect, std::span<std::byte> out) const;
  void set_state(std::int64_t cell, State state);
  [[nodiscard]] State& state_of(std::int64_t cell) { return states_[static_cast<std::size_t>(cell)]; }
  [[nodiscard]] std::uint64_t place_of_row(std::int64_t row) const {
    return region_ + static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(grid_.row_bytes());
  }

  const CellDecoder& decoder_;
  const CellGrid& grid_;
  const int plane_;
  const std::shared_ptr<ScratchFile> scratch_;

  std::mutex order_;  // held while a sequential cell is decoded; taken before mutex_
  // Shared while rows are read, so that none is released under the reader.
  std::shared_mutex mutex_;
  std::condition_variable_any decoded_;
  bool is_prepared_ = false;
  std::uint64_t region_ = 0;
  std::vector<State> states_;          // of every cell
  std::int64_t first_wanted_row_ = 0;  // by release_rows_before()
  std::uint64_t released_to_ = 0;      // everything before it in the region has been given back
};

}  // namespace vt::source
