#include "builder/source/cells/spilled_rows.h"

#include <algorithm>

namespace vt::source {

SpilledRows::SpilledRows(const CellDecoder& decoder, int plane, std::shared_ptr<ScratchFile> scratch)
    : decoder_(decoder), grid_(decoder.grid()), plane_(plane), scratch_(std::move(scratch)) {}

SpilledRows::~SpilledRows() {
  if (is_prepared_) static_cast<void>(scratch_->release(region_, place_of_row(grid_.height) - region_));
}

Result<void> SpilledRows::prepare() {
  const std::unique_lock lock(mutex_);
  if (is_prepared_) return {};
  VT_ASSIGN(region_, scratch_->reserve(static_cast<std::uint64_t>(grid_.height) * static_cast<std::uint64_t>(grid_.row_bytes())));
  states_.resize(static_cast<std::size_t>(grid_.cells_down()), State::kNew);
  released_to_ = region_;
  is_prepared_ = true;
  return {};
}

Result<void> SpilledRows::read(const Rect& rect, std::span<std::byte> out) {
  const std::int64_t first_cell = grid_.cell_of_row(rect.row);
  const std::int64_t last_cell = grid_.cell_of_row(rect.row + rect.rows - 1);
  for (;;) {
    std::int64_t missing = first_cell;
    {
      const std::shared_lock lock(mutex_);
      if (is_prepared_) {
        while (missing <= last_cell && state_of(missing) == State::kPresent) ++missing;
        if (missing > last_cell) return read_present(rect, out);
      }
    }
    VT_CHECK(prepare());
    VT_CHECK(grid_.is_sequential ? make_in_order(missing) : make(missing));
  }
}

Result<void> SpilledRows::read_present(const Rect& rect, std::span<std::byte> out) const {
  if (rect.columns == grid_.block_width) return scratch_->read(place_of_row(rect.row), out);
  const auto row_bytes = static_cast<std::size_t>(rect.columns * grid_.stride);
  for (std::int64_t row = 0; row < rect.rows; ++row) {
    VT_CHECK(scratch_->read(place_of_row(rect.row + row) + static_cast<std::uint64_t>(rect.column * grid_.stride),
                            out.subspan(static_cast<std::size_t>(row) * row_bytes, row_bytes)));
  }
  return {};
}

void SpilledRows::set_state(std::int64_t cell, State state) {
  const std::unique_lock lock(mutex_);
  state_of(cell) = state;
  // A cell that comes back after it was released is given back by the next hint.
  if (state == State::kPresent) {
    const std::uint64_t place = place_of_row(grid_.first_row(cell));
    released_to_ = std::min(released_to_, place - place % ScratchFile::kPageBytes);
  }
}

Result<void> SpilledRows::decode_and_keep(std::int64_t cell) {
  Result<Block> samples = fail(ErrorCode::kIo, "not enough memory for one decoded block");
  try {
    samples = decoder_.decode_cell(0, cell, plane_);
  } catch (const std::bad_alloc&) {
  }
  Result<void> kept = samples ? scratch_->write(place_of_row(grid_.first_row(cell)), *samples)
                              : Result<void>(tl::unexpected<Error>(std::move(samples).error()));
  set_state(cell, kept ? State::kPresent : State::kReleased);
  return kept;
}

Result<void> SpilledRows::make(std::int64_t cell) {
  {
    std::unique_lock lock(mutex_);
    while (state_of(cell) == State::kDecoding) decoded_.wait(lock);
    if (state_of(cell) == State::kPresent) return {};
    state_of(cell) = State::kDecoding;
  }
  const Result<void> kept = decode_and_keep(cell);
  decoded_.notify_all();
  return kept;
}

Result<void> SpilledRows::make_in_order(std::int64_t wanted) {
  const std::scoped_lock in_order(order_);
  // From the first cell of the block that was never decoded: what is passed over now need not be decoded
  // again for those who come later.
  const std::int64_t block_first = wanted - wanted % grid_.cells_per_block();
  std::int64_t cell = wanted;
  {
    const std::shared_lock lock(mutex_);
    if (state_of(wanted) == State::kPresent) return {};
    while (state_of(cell) == State::kNew && cell > block_first && state_of(cell - 1) == State::kNew) --cell;
  }
  for (; cell <= wanted; ++cell) {
    {
      const std::unique_lock lock(mutex_);
      const bool is_passed_over = cell < wanted && grid_.first_row(cell) + grid_.cell_rows(cell) <= first_wanted_row_;
      state_of(cell) = is_passed_over ? State::kReleased : State::kDecoding;
      if (is_passed_over) continue;  // the decoder skips it by itself
    }
    VT_CHECK(decode_and_keep(cell));
  }
  return {};
}

void SpilledRows::release_rows_before(std::int64_t row) {
  const std::unique_lock lock(mutex_);
  first_wanted_row_ = std::max(first_wanted_row_, row >= grid_.height ? grid_.height : row - kKeptRows);
  if (!is_prepared_ || first_wanted_row_ <= 0) return;
  // Whole cells, and none that a thread is just writing.
  std::int64_t end = first_wanted_row_ >= grid_.height ? grid_.cells_down() : grid_.cell_of_row(first_wanted_row_);
  end = std::find(states_.begin(), states_.begin() + end, State::kDecoding) - states_.begin();
  const std::uint64_t end_place = place_of_row(std::min(grid_.first_row(end), grid_.height));
  const std::uint64_t end_page = end_place - end_place % ScratchFile::kPageBytes;
  if (end_page <= released_to_ || !scratch_->release(released_to_, end_page - released_to_)) return;
  released_to_ = end_page;
  std::replace(states_.begin(), states_.begin() + end, State::kPresent, State::kReleased);
}

}  // namespace vt::source
