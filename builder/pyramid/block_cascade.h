// Filters one block of a layer through several levels in one sweep from north to south. Only a few rows of each level are alive at a time,
// so everything stays in the processor's cache and memory does not depend on the block's height.
//
// The caller writes base rows in order (begin_row, end_row) and receives finished rows of every level through RowSink, each with its
// neighbours. The block asks for an apron around its core that is wide enough for every level, so a level's texels come from the same
// values in the same order as if the whole image were filtered at once: blocking never shows in the result. One object per thread.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "builder/pyramid/halving_kernel.h"
#include "store/tile_id.h"

namespace vt::pyramid {

// What one block must have of each of its levels; index 0 is the block's base.
struct BlockLevel {
  TexelRect core;    // texels the block is responsible for, inside the data
  TexelRect active;  // core and apron, inside the data: what is computed
  TexelRect data;    // the data rectangle of the level
};

// `core` is the block on its base level (before clipping), `data` the base level's data rectangle; `outputs` levels are wanted, the base
// included, and one more as carry when `with_carry`.
[[nodiscard]] std::vector<BlockLevel> plan_block(const TexelRect& core, const TexelRect& data, int outputs, bool with_carry,
                                                 const HalvingKernel& kernel);

class RowSink {
 public:
  virtual ~RowSink() = default;
  // Row `y` of level `k` (0 = base); pointers in `rows` are at column core.x and `core.width` texels belong to the block.
  virtual void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) = 0;
};

class BlockCascade {
 public:
  // `levels` as from plan_block; not empty, and levels[0].active is not empty.
  BlockCascade(std::vector<BlockLevel> levels, int planes, const HalvingKernel& kernel);

  [[nodiscard]] const BlockLevel& level(int k) const { return state_[static_cast<std::size_t>(k)].plan; }
  [[nodiscard]] int level_count() const { return static_cast<int>(state_.size()); }

  // Where to write the next base row: level(0).active.width texels, row after row from active.y.
  [[nodiscard]] channels::PlaneRow begin_row();
  // The row is written; `opaque`: all its weights are exactly 1. Passes on every row that can now be finished.
  void end_row(bool opaque, RowSink& sink);

 private:
  static constexpr std::int64_t kPad = 32;  // zeros on either side of a row, for taps that reach outside the data

  struct LevelState {
    BlockLevel plan;
    bool clipped_x = false;  // taps of the next level reach past the data's west or east edge
    std::int64_t stride = 0;
    std::int64_t next_row = 0;      // the row that is written next
    std::int64_t next_emitted = 0;  // the row that the sink gets next
    std::vector<float> ring;
    std::vector<std::uint8_t> opaque;  // per ring row
  };

  [[nodiscard]] float* row_at(LevelState& level, std::int64_t y, int plane);
  [[nodiscard]] const float* row_or_zeros(LevelState& level, std::int64_t y, int plane);
  [[nodiscard]] channels::ConstPlaneRow planes_at(LevelState& level, std::int64_t y, std::int64_t x);
  void emit_rows(int k, RowSink& sink);
  void make_coarser_rows(int k, RowSink& sink);
  void halve_into(LevelState& fine, LevelState& coarse);

  HalvingKernel kernel_;
  int planes_;
  std::int64_t ring_rows_;
  std::vector<LevelState> state_;
  std::vector<float> zeros_;
  std::vector<float> combined_;
  std::vector<float> scratch_;
};

}  // namespace vt::pyramid
