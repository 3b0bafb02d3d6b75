#include "runtime/sub_load.h"

#include <algorithm>
#include <cassert>

namespace vt::runtime {
namespace {

// Small uploads measure the call more than the bus; a single one must not swing the rate. Half a second of
// frames at 60 Hz settles it.
constexpr double kLearningRate = 0.1;
// The first uploads come before anything is known: a small probe.
constexpr std::size_t kProbeBytes = 64 * 1024;
// Below this the clock's own grain dominates.
constexpr std::size_t kLeastMeasuredBytes = 4 * 1024;

}  // namespace

BandCursor::BandCursor(TexelFormat format, int tile_exponent, int mips) : format_(format), tile_exponent_(tile_exponent), mips_(mips) {}

std::optional<Band> BandCursor::next(std::size_t most_bytes) {
  assert(!done());
  const FormatInfo& info = format_info(format_);
  const std::size_t most_blocks = most_bytes / info.block_bytes;
  if (most_blocks == 0) return std::nullopt;

  const std::size_t row = std::max<std::size_t>(1, (std::size_t{1} << (tile_exponent_ - mip_)) / info.block_edge);
  Band band{.mip = mip_,
            .x = static_cast<int>(block_x_ * info.block_edge),
            .y = static_cast<int>(block_y_ * info.block_edge),
            .width = 0,
            .height = 0,
            .offset = offset_,
            .bytes = 0};
  std::size_t columns = row - block_x_;
  std::size_t rows = 1;
  if (block_x_ == 0 && most_blocks >= row) {
    rows = std::min(most_blocks / row, row - block_y_);
  } else {
    columns = std::min(columns, most_blocks);
  }
  band.width = static_cast<int>(columns * info.block_edge);
  band.height = static_cast<int>(rows * info.block_edge);
  band.bytes = columns * rows * info.block_bytes;

  offset_ += band.bytes;
  block_x_ += columns;
  if (block_x_ == row) {
    block_x_ = 0;
    block_y_ += rows;
  }
  if (block_y_ == row) {
    block_y_ = 0;
    ++mip_;
  }
  return band;
}

void SubLoadController::set_budget(std::size_t bytes, double seconds) {
  budget_bytes_ = bytes;
  budget_seconds_ = seconds;
}

std::size_t SubLoadController::bytes_per_update() const {
  if (budget_seconds_ <= 0.0) return budget_bytes_;
  if (seconds_per_byte_ <= 0.0) return std::min(budget_bytes_, kProbeBytes);
  const double by_time = budget_seconds_ / seconds_per_byte_;
  // Never so little that nothing more could be learned: one bad stall would stop the uploads for good.
  const double at_least = std::max(by_time, static_cast<double>(kLeastMeasuredBytes));
  return at_least >= static_cast<double>(budget_bytes_) ? budget_bytes_ : static_cast<std::size_t>(at_least);
}

void SubLoadController::record(std::size_t bytes, double seconds) {
  if (bytes < kLeastMeasuredBytes) return;
  const double measured = std::max(seconds, 1e-9) / static_cast<double>(bytes);
  seconds_per_byte_ = seconds_per_byte_ == 0.0 ? measured : seconds_per_byte_ + kLearningRate * (measured - seconds_per_byte_);
}

}  // namespace vt::runtime
