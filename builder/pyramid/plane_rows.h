// The rows of one level of a block that are alive at a time, as planes of floats. A row holds one or two runs
// of columns, each with a pad on either side for taps that reach past it: what lies in a pad is nothing at an
// edge of the data, and the other side at the seam of a closed layer. One object per thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pyramid/cascade.h"
#include "builder/pyramid/layer_shape.h"

namespace vt::pyramid {

// What a plane holds where there are no data.
[[nodiscard]] float neutral_value(channels::PlaneRule rule);

// Columns that lie side by side: the active ones of a level, or those beyond the seam.
struct ColumnRun {
  TexelRect rect;
  std::int64_t at = 0;  // place of its first column in a row; the first active column has place 0
};

class PlaneRows {
 public:
  static constexpr std::int64_t kPad = 32;

  // The last `rows` rows are kept. `reach` is the kernel's.
  PlaneRows(const BlockLevel& plan, const LayerShape& layer, std::span<const channels::PlaneRule> rules, int rows, int reach);

  [[nodiscard]] const BlockLevel& plan() const { return plan_; }
  [[nodiscard]] std::span<const ColumnRun> runs() const { return runs_; }
  // The data end at the west and east edges, and do not go on at the other side.
  [[nodiscard]] bool ends_in_x() const { return ends_in_x_; }
  // Columns of the active run count on past the edges.
  [[nodiscard]] bool wraps() const { return wraps_; }
  // Floats of a row of one plane from kPad places before the first active column on, pads and all.
  [[nodiscard]] std::int64_t stride() const { return stride_; }

  // Rows are written in order, from active.y to active.bottom() - 1: all runs of row next(), then end_row().
  [[nodiscard]] std::int64_t next() const { return next_; }
  [[nodiscard]] bool is_full() const { return next_ == plan_.active.bottom(); }
  [[nodiscard]] channels::PlaneRow begin_row();
  void end_row(bool opaque);  // all weights of all runs are 1

  [[nodiscard]] bool has(std::int64_t y) const { return y >= plan_.active.y && y < plan_.active.bottom(); }
  [[nodiscard]] bool is_opaque(std::int64_t y) const { return opaque_[slot_of(y)] != 0; }
  // Place 0 of a row that was written and is still kept, and of a row without data when there is none.
  [[nodiscard]] float* row(std::int64_t y, int plane) { return floats_.data() + offset_of(slot_of(y), plane); }
  [[nodiscard]] const float* row_or_nothing(std::int64_t y, int plane) const {
    return floats_.data() + offset_of(has(y) ? slot_of(y) : static_cast<std::size_t>(rows_), plane);
  }
  [[nodiscard]] channels::ConstPlaneRow planes_or_nothing(std::int64_t y, std::int64_t place) const;

 private:
  // A pad's texel that shows the other side of the seam.
  struct SeamTexel {
    std::int64_t at;
    std::int64_t first;
    std::int64_t second;
    float share;
  };

  void plan_seam(const LayerShape& layer, std::int64_t reach);
  void fill_pads(std::size_t slot);
  [[nodiscard]] static float remainder_of(const float* values, const float* remainders, const SeamTexel& texel);
  [[nodiscard]] std::size_t slot_of(std::int64_t y) const { return static_cast<std::size_t>((y - plan_.active.y) % rows_); }
  [[nodiscard]] std::size_t offset_of(std::size_t slot, int plane) const {
    return (slot * rules_.size() + static_cast<std::size_t>(plane)) * static_cast<std::size_t>(stride_) + kPad;
  }

  BlockLevel plan_;
  std::vector<channels::PlaneRule> rules_;
  std::int64_t rows_;
  bool ends_in_x_;
  bool wraps_;
  std::vector<ColumnRun> runs_;
  std::vector<SeamTexel> seam_;
  std::int64_t stride_ = 0;
  std::int64_t next_ = 0;
  std::vector<float> floats_;  // the kept rows, and one without data
  std::vector<std::uint8_t> opaque_;
};

}  // namespace vt::pyramid
