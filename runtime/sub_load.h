// Second stage of paging: how much of a tile goes to GL in one update. A tile is cut into bands of whole rows
// (below one row: parts of a row), so an update never sends more than its budget; the budget in time becomes
// bytes through a rate learned from the uploads themselves. No GL, no clock of its own; belongs to the GL
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "store/texel_format.h"

namespace vt::runtime {

// A piece of one mip: contiguous bytes in TileImage::bytes. Coordinates in texels.
struct Band {
  int mip = 0;
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  std::size_t offset = 0;
  std::size_t bytes = 0;
};

// Walks through a tile band by band.
class BandCursor {
 public:
  BandCursor() = default;
  BandCursor(TexelFormat format, int tile_exponent, int mips);
  // The next piece of at most `most_bytes`; nullopt when not even one block fits. Not past the end.
  [[nodiscard]] std::optional<Band> next(std::size_t most_bytes);
  [[nodiscard]] bool done() const { return mip_ >= mips_; }

 private:
  TexelFormat format_ = TexelFormat::kRgb8;
  int tile_exponent_ = 0;
  int mips_ = 0;
  int mip_ = 0;
  std::size_t block_x_ = 0;  // first block not given out yet
  std::size_t block_y_ = 0;
  std::size_t offset_ = 0;
};

// The control law: bytes allowed = the smaller of the byte budget and time budget / learned rate.
class SubLoadController {
 public:
  // `budget_seconds` 0: bytes alone count.
  SubLoadController(std::size_t budget_bytes, double budget_seconds) : budget_bytes_(budget_bytes), budget_seconds_(budget_seconds) {}
  void set_budget(std::size_t bytes, double seconds);

  // One upload and what it took.
  void record(std::size_t bytes, double seconds);
  // What one update may send in all, as learned so far.
  [[nodiscard]] std::size_t bytes_per_update() const;
  [[nodiscard]] double seconds_per_byte() const { return seconds_per_byte_; }

 private:
  std::size_t budget_bytes_;
  double budget_seconds_;
  double seconds_per_byte_ = 0.0;  // 0: nothing learned yet
};

}  // namespace vt::runtime
