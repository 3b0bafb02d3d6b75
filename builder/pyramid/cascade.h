// Filters one block of a layer through several levels in one sweep from north to south. Only a few rows of
// each level are alive at a time, so everything stays in the processor's cache and memory does not depend on
// the block's height.
//
// The caller feeds base rows in order and receives finished rows of every output level through RowSink, each
// with its neighbours; the level above the outputs is kept as carry, from which the next tier goes on. The
// block asks for an apron around its core that is wide enough for every level, so a level's texels come from
// the same values in the same order as if the whole image were filtered at once: blocking never shows in the
// result. How values combine differs: PlaneCascade sums planes, ClassCascade counts classes. One object per
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/channels/codec/class_areas.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/pyramid/layer_shape.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::pyramid {

// What one block must have of each of its levels; index 0 is the block's base.
struct BlockLevel {
  TexelRect core;    // texels the block is responsible for, inside the data
  TexelRect active;  // core and apron: what is computed. Inside the data, but columns of a level that wraps count on past its edges
  TexelRect beyond;  // of a closed level that does not wrap: what the ends of `active` see of the other side of the seam; may be empty
  TexelRect data;    // the data rectangle of the level
  int depth = 0;     // levels above the layer's finest
};

// `core` is the block on its base level (before clipping), which lies `depth` levels above the finest of
// `layer`; `outputs` levels are wanted, the base included, and one more as carry when `with_carry`.
[[nodiscard]] std::vector<BlockLevel> plan_block(const TexelRect& core, const LayerShape& layer, int depth, int outputs, bool with_carry,
                                                 const HalvingKernel& kernel);
// The same for a layer that ends at the edges of `data` and whose finest level is the base.
[[nodiscard]] inline std::vector<BlockLevel> plan_block(const TexelRect& core, const TexelRect& data, int outputs, bool with_carry,
                                                        const HalvingKernel& kernel) {
  return plan_block(core, {.data = data}, 0, outputs, with_carry, kernel);
}

class RowSink {
 public:
  virtual ~RowSink() = default;
  // Row `y` of level `k` (0 = base); pointers in `rows` are at column core.x and `core.width` texels belong
  // to the block.
  virtual void row(int k, std::int64_t y, const channels::RowNeighbourhood& rows) = 0;
};

// Tiles of carry of one row of tiles, as carry_bytes() gave them.
struct CarryTiles {
  std::int64_t row = 0;                           // of tiles
  std::span<const std::int64_t> columns;          // of tiles, those of carry_columns()
  std::span<const std::vector<std::byte>> tiles;  // one for each column; empty bytes: there is no carry, because there are no data
};

// The columns of tiles that a block whose base is carry has to be fed with, ascending.
[[nodiscard]] std::vector<std::int64_t> carry_columns(const BlockLevel& base, int tile_exponent);

class Cascade {
 public:
  virtual ~Cascade() = default;
  Cascade(const Cascade&) = delete;
  Cascade& operator=(const Cascade&) = delete;

  [[nodiscard]] const BlockLevel& level(int k) const { return levels_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] int outputs() const { return outputs_; }
  [[nodiscard]] bool has_carry() const { return outputs_ < level_count(); }

  // Where to write the next base row, in all planes of the codec: level(0).active.width texels, row after row
  // from active.y. Not of a base that has a part beyond the seam, which comes as carry.
  [[nodiscard]] virtual channels::PlaneRow begin_row() = 0;
  // The row is written; `opaque`: all its weights are exactly 1. Passes on every row that can now be
  // finished.
  virtual void end_row(bool opaque, RowSink& sink) = 0;
  // Instead of begin_row() and end_row(), of layers whose base texels may be of several classes: row `row`
  // (0 = the first) of `areas`, which follow each other from the first to the last column of the active
  // rectangle.
  virtual void put_area_row(std::span<const channels::ClassAreaBlock* const> areas, std::int64_t row, RowSink& sink) = 0;
  // An error when a row that was written cannot be part of the layer. The cascade goes on without its data,
  // so asking now and then is enough.
  [[nodiscard]] virtual Result<void> status() const { return {}; }

  // Instead of rows, of a tier that goes on from carry: all rows of the active rectangle in one row of tiles.
  // kCorrupt: bytes that are no carry.
  [[nodiscard]] virtual Result<void> feed_carry(const CarryTiles& carry, RowSink& sink) = 0;
  // After the last row, when has_carry(): the tile of carry that the block leaves, for feed_carry.
  virtual void carry_bytes(std::vector<std::byte>& out) const = 0;

 protected:
  // `levels` as from plan_block, `outputs` of them are given out.
  Cascade(std::vector<BlockLevel> levels, int outputs) : levels_(std::move(levels)), outputs_(outputs) {}

 private:
  std::vector<BlockLevel> levels_;
  int outputs_;
};

}  // namespace vt::pyramid
