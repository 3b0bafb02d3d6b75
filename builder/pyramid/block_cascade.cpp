#include "builder/pyramid/block_cascade.h"

#include <algorithm>
#include <cassert>

#include "builder/channels/coverage.h"
#include "builder/pyramid/reduce_rows.h"

namespace vt::pyramid {

std::vector<BlockLevel> plan_block(const TexelRect& core, const TexelRect& data, int outputs, bool with_carry,
                                   const HalvingKernel& kernel) {
  const int count = outputs + (with_carry ? 1 : 0);
  std::vector<BlockLevel> levels(static_cast<std::size_t>(count));
  std::int64_t apron = 0;
  for (int k = count - 1; k >= 0; --k) {
    // A level that becomes texels needs one more texel around it, for colour borrowed from neighbours; a carry level does not.
    if (k < outputs) apron = std::max<std::int64_t>(apron, 1);
    BlockLevel& level = levels[static_cast<std::size_t>(k)];
    const TexelRect core_k{core.x >> k, core.y >> k, core.width >> k, core.height >> k};
    level.data = coarser(data, k);
    level.core = intersect(core_k, level.data);
    level.active = intersect(grown(core_k, apron), level.data);
    apron = 2 * apron + kernel.reach();  // what the next finer level must have around its core
  }
  return levels;
}

BlockCascade::BlockCascade(std::vector<BlockLevel> levels, int planes, const HalvingKernel& kernel)
    : kernel_(kernel), planes_(planes), ring_rows_(kernel.taps + 4) {
  assert(!levels.empty() && !levels[0].active.empty());
  std::int64_t widest = 0;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    LevelState state;
    state.plan = levels[k];
    const TexelRect& active = state.plan.active;
    if (k + 1 < levels.size()) {
      const TexelRect& next = levels[k + 1].active;
      state.clipped_x = 2 * next.x - kernel.reach() < active.x || 2 * next.right() + kernel.reach() > active.right();
    }
    state.stride = active.width + 2 * kPad;
    state.next_row = active.y;
    state.next_emitted = state.plan.core.y;
    state.ring.assign(static_cast<std::size_t>(ring_rows_ * planes_ * state.stride), 0.0F);
    state.opaque.assign(static_cast<std::size_t>(ring_rows_), 0);
    widest = std::max(widest, state.stride);
    state_.push_back(std::move(state));
  }
  zeros_.assign(static_cast<std::size_t>(widest), 0.0F);
  combined_.assign(static_cast<std::size_t>(widest), 0.0F);
  scratch_.assign(halve_scratch_floats(static_cast<std::size_t>(widest)), 0.0F);
}

float* BlockCascade::row_at(LevelState& level, std::int64_t y, int plane) {
  const std::int64_t slot = (y - level.plan.active.y) % ring_rows_;
  return level.ring.data() + (slot * planes_ + plane) * level.stride + kPad;
}

// Rows outside the data have no weight.
const float* BlockCascade::row_or_zeros(LevelState& level, std::int64_t y, int plane) {
  const TexelRect& active = level.plan.active;
  if (y < active.y || y >= active.bottom()) return zeros_.data() + kPad;
  return row_at(level, y, plane);
}

channels::ConstPlaneRow BlockCascade::planes_at(LevelState& level, std::int64_t y, std::int64_t x) {
  channels::ConstPlaneRow rows{};
  for (int p = 0; p < planes_; ++p) rows[static_cast<std::size_t>(p)] = row_or_zeros(level, y, p) + (x - level.plan.active.x);
  return rows;
}

channels::PlaneRow BlockCascade::begin_row() {
  LevelState& base = state_[0];
  assert(base.next_row < base.plan.active.bottom());
  channels::PlaneRow rows{};
  for (int p = 0; p < planes_; ++p) rows[static_cast<std::size_t>(p)] = row_at(base, base.next_row, p);
  return rows;
}

void BlockCascade::end_row(bool opaque, RowSink& sink) {
  LevelState& base = state_[0];
  base.opaque[static_cast<std::size_t>((base.next_row - base.plan.active.y) % ring_rows_)] = opaque ? 1 : 0;
  ++base.next_row;
  emit_rows(0, sink);
  make_coarser_rows(0, sink);
}

// A row is passed on as soon as the one below it exists.
void BlockCascade::emit_rows(int k, RowSink& sink) {
  LevelState& level = state_[static_cast<std::size_t>(k)];
  const std::int64_t ready = level.next_row == level.plan.active.bottom() ? level.next_row : level.next_row - 1;
  for (; level.next_emitted < std::min(ready, level.plan.core.bottom()); ++level.next_emitted) {
    const std::int64_t y = level.next_emitted;
    const std::int64_t x = level.plan.core.x;
    const bool opaque = level.opaque[static_cast<std::size_t>((y - level.plan.active.y) % ring_rows_)] != 0;
    sink.row(k, y, {planes_at(level, y - 1, x), planes_at(level, y, x), planes_at(level, y + 1, x), opaque});
  }
}

void BlockCascade::make_coarser_rows(int k, RowSink& sink) {
  if (k + 1 == level_count()) return;
  LevelState& fine = state_[static_cast<std::size_t>(k)];
  LevelState& coarse = state_[static_cast<std::size_t>(k) + 1];
  const bool fine_done = fine.next_row == fine.plan.active.bottom();
  while (coarse.next_row < coarse.plan.active.bottom() && (fine_done || 2 * coarse.next_row + 1 + kernel_.reach() < fine.next_row)) {
    halve_into(fine, coarse);
    ++coarse.next_row;
    emit_rows(k + 1, sink);
    make_coarser_rows(k + 1, sink);
  }
}

void BlockCascade::halve_into(LevelState& fine, LevelState& coarse) {
  const std::int64_t y = coarse.next_row;
  const std::int64_t first = 2 * y - kernel_.reach();
  bool opaque = !fine.clipped_x;
  for (std::int64_t row = first; row < first + kernel_.taps && opaque; ++row)
    opaque = row >= fine.plan.active.y && row < fine.plan.active.bottom() &&
             fine.opaque[static_cast<std::size_t>((row - fine.plan.active.y) % ring_rows_)] != 0;

  const TexelRect& active = coarse.plan.active;
  const std::int64_t start = 2 * active.x - fine.plan.active.x;  // fine index under the first coarse texel; may be -1
  const int last_plane = opaque ? planes_ - 1 : planes_;
  channels::PlaneRow out{};
  for (int p = 0; p < planes_; ++p) out[static_cast<std::size_t>(p)] = row_at(coarse, y, p);
  for (int p = 0; p < last_plane; ++p) {
    if (kernel_.taps == 2) {
      halve_two_rows(row_or_zeros(fine, first, p) + start, row_or_zeros(fine, first + 1, p) + start, kernel_,
                     static_cast<std::size_t>(active.width), out[static_cast<std::size_t>(p)]);
      continue;
    }
    const float* rows[kMaxTaps];
    for (int t = 0; t < kernel_.taps; ++t) rows[t] = row_or_zeros(fine, first + t, p) - kPad;
    combine_rows(rows, kernel_, static_cast<std::size_t>(fine.stride), combined_.data());
    halve_row(combined_.data() + kPad + start, kernel_, static_cast<std::size_t>(active.width), scratch_.data(),
              out[static_cast<std::size_t>(p)]);
  }

  if (opaque) {
    std::fill_n(out[static_cast<std::size_t>(planes_ - 1)], active.width, 1.0F);
  } else {
    const std::int64_t x = 2 * active.x;
    opaque = channels::settle_coverage(planes_at(fine, 2 * y, x), planes_at(fine, 2 * y + 1, x), planes_, active.width, out);
  }
  coarse.opaque[static_cast<std::size_t>((y - active.y) % ring_rows_)] = opaque ? 1 : 0;
}

}  // namespace vt::pyramid
