#include "builder/pyramid/plane_cascade.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "builder/channels/coverage.h"
#include "builder/pyramid/plane_carry.h"
#include "builder/pyramid/reduce_rows.h"

namespace vt::pyramid {

using channels::PlaneRule;

PlaneCascade::PlaneCascade(std::vector<BlockLevel> levels, int outputs, std::span<const PlaneRule> rules, int weight_plane,
                           const HalvingKernel& kernel, int tile_exponent)
    : Cascade(std::move(levels), outputs),
      kernel_(kernel),
      rules_(rules.begin(), rules.end()),
      planes_(static_cast<int>(rules.size())),
      weight_plane_(weight_plane),
      tile_exponent_(tile_exponent),
      ring_rows_(kernel.taps + 4) {
  assert(level_count() > 0 && !level(0).active.empty());
  for (int k = 0; k < level_count(); ++k) {
    LevelState state;
    state.plan = level(k);
    const TexelRect& active = state.plan.active;
    if (k + 1 < level_count()) {
      const TexelRect& next = level(k + 1).active;
      state.clipped_x = 2 * next.x - kernel.reach() < active.x || 2 * next.right() + kernel.reach() > active.right();
    }
    state.stride = active.width + 2 * kPad;
    state.next_row = active.y;
    state.next_emitted = state.plan.core.y;
    state.ring.resize(static_cast<std::size_t>(ring_rows_ * planes_ * state.stride));
    for (std::int64_t row = 0; row < ring_rows_ * planes_; ++row)
      std::fill_n(state.ring.begin() + row * state.stride, state.stride, neutral(rules_[static_cast<std::size_t>(row % planes_)]));
    state.opaque.assign(static_cast<std::size_t>(ring_rows_), 0);
    widest_ = std::max(widest_, state.stride);
    state_.push_back(std::move(state));
  }
  nothing_.resize(static_cast<std::size_t>(widest_ * planes_));
  for (int p = 0; p < planes_; ++p) std::fill_n(nothing_.begin() + p * widest_, widest_, neutral(rules_[static_cast<std::size_t>(p)]));
  combined_.assign(static_cast<std::size_t>(2 * widest_), 0.0F);
  scratch_.assign(halve_scratch_floats(static_cast<std::size_t>(widest_)), 0.0F);
  if (has_carry()) {
    const auto edge = static_cast<std::size_t>(1) << tile_exponent_;
    carry_.resize(static_cast<std::size_t>(planes_) * edge * edge);
    for (std::size_t p = 0; p < rules_.size(); ++p)
      std::fill_n(carry_.begin() + static_cast<std::ptrdiff_t>(p * edge * edge), edge * edge, neutral(rules_[p]));
  }
}

// What a plane holds where there are no data.
float PlaneCascade::neutral(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::kLinear:
      return 0.0F;
    case PlaneRule::kLeast:
      return std::numeric_limits<float>::infinity();
    case PlaneRule::kGreatest:
      return -std::numeric_limits<float>::infinity();
  }
  return 0.0F;
}

float* PlaneCascade::row_at(LevelState& level, std::int64_t y, int plane) {
  const std::int64_t slot = (y - level.plan.active.y) % ring_rows_;
  return level.ring.data() + (slot * planes_ + plane) * level.stride + kPad;
}

const float* PlaneCascade::row_or_nothing(LevelState& level, std::int64_t y, int plane) {
  const TexelRect& active = level.plan.active;
  if (y < active.y || y >= active.bottom()) return nothing_.data() + plane * widest_ + kPad;
  return row_at(level, y, plane);
}

channels::ConstPlaneRow PlaneCascade::planes_at(LevelState& level, std::int64_t y, std::int64_t x) {
  channels::ConstPlaneRow rows{};
  for (int p = 0; p < planes_; ++p) rows[static_cast<std::size_t>(p)] = row_or_nothing(level, y, p) + (x - level.plan.active.x);
  return rows;
}

channels::PlaneRow PlaneCascade::begin_row() {
  LevelState& base = state_[0];
  assert(base.next_row < base.plan.active.bottom());
  channels::PlaneRow rows{};
  for (int p = 0; p < planes_; ++p) rows[static_cast<std::size_t>(p)] = row_at(base, base.next_row, p);
  return rows;
}

void PlaneCascade::end_row(bool opaque, RowSink& sink) {
  LevelState& base = state_[0];
  base.opaque[static_cast<std::size_t>((base.next_row - base.plan.active.y) % ring_rows_)] = opaque ? 1 : 0;
  ++base.next_row;
  emit_rows(0, sink);
  make_coarser_rows(0, sink);
}

// A row is passed on as soon as the one below it exists.
void PlaneCascade::emit_rows(int k, RowSink& sink) {
  LevelState& level = state_[static_cast<std::size_t>(k)];
  const std::int64_t ready = level.next_row == level.plan.active.bottom() ? level.next_row : level.next_row - 1;
  for (; level.next_emitted < std::min(ready, level.plan.core.bottom()); ++level.next_emitted) {
    const std::int64_t y = level.next_emitted;
    const std::int64_t x = level.plan.core.x;
    if (k == outputs()) {
      keep_carry_row(y, planes_at(level, y, x));
      continue;
    }
    const bool opaque = level.opaque[static_cast<std::size_t>((y - level.plan.active.y) % ring_rows_)] != 0;
    sink.row(k, y, {planes_at(level, y - 1, x), planes_at(level, y, x), planes_at(level, y + 1, x), opaque});
  }
}

void PlaneCascade::keep_carry_row(std::int64_t y, const channels::ConstPlaneRow& row) {
  const TexelRect& core = level(outputs()).core;
  const std::int64_t edge = std::int64_t{1} << tile_exponent_;
  for (int p = 0; p < planes_; ++p)
    std::copy_n(row[static_cast<std::size_t>(p)], core.width,
                carry_.begin() + (p * edge + (y & (edge - 1))) * edge + (core.x & (edge - 1)));
}

void PlaneCascade::carry_bytes(std::vector<std::byte>& out) const {
  pack_carry(carry_, static_cast<std::size_t>(planes_), static_cast<std::size_t>(1) << tile_exponent_, out);
}

Result<void> PlaneCascade::feed_carry(const CarryTiles& carry, RowSink& sink) {
  const std::int64_t edge = std::int64_t{1} << tile_exponent_;
  const auto plane_floats = static_cast<std::size_t>(edge * edge);
  const std::size_t tile_floats = static_cast<std::size_t>(planes_) * plane_floats;
  carry_read_.resize(carry.tiles.size() * tile_floats);
  for (std::size_t i = 0; i < carry.tiles.size(); ++i) {
    const auto tile = std::span(carry_read_).subspan(i * tile_floats, tile_floats);
    if (carry.tiles[i].empty()) {
      for (std::size_t p = 0; p < rules_.size(); ++p) std::ranges::fill(tile.subspan(p * plane_floats, plane_floats), neutral(rules_[p]));
    } else {
      VT_CHECK(unpack_carry(carry.tiles[i], static_cast<std::size_t>(planes_), static_cast<std::size_t>(edge), tile));
    }
  }

  const TexelRect& active = level(0).active;
  const std::int64_t end_row = std::min((carry.row + 1) * edge, active.bottom());
  for (std::int64_t y = std::max(carry.row * edge, active.y); y < end_row; ++y) {
    const channels::PlaneRow planes = begin_row();
    for (std::int64_t x = active.x; x < active.right();) {
      const std::int64_t column = x >> tile_exponent_;
      const std::int64_t count = std::min((column + 1) << tile_exponent_, active.right()) - x;
      const float* tile = carry_read_.data() + static_cast<std::size_t>(column - carry.first_column) * tile_floats;
      for (int p = 0; p < planes_; ++p)
        std::copy_n(tile + (p * edge + (y & (edge - 1))) * edge + (x & (edge - 1)), count,
                    planes[static_cast<std::size_t>(p)] + (x - active.x));
      x += count;
    }
    const float* weights = planes[static_cast<std::size_t>(weight_plane_)];
    this->end_row(std::all_of(weights, weights + active.width, [](float w) { return w == 1.0F; }), sink);
  }
  return {};
}

void PlaneCascade::make_coarser_rows(int k, RowSink& sink) {
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

void PlaneCascade::halve_into(LevelState& fine, LevelState& coarse) {
  const std::int64_t y = coarse.next_row;
  const std::int64_t first = 2 * y - kernel_.reach();
  bool opaque = !fine.clipped_x;
  for (std::int64_t row = first; row < first + kernel_.taps && opaque; ++row)
    opaque = row >= fine.plan.active.y && row < fine.plan.active.bottom() &&
             fine.opaque[static_cast<std::size_t>((row - fine.plan.active.y) % ring_rows_)] != 0;

  const TexelRect& active = coarse.plan.active;
  const std::int64_t start = 2 * active.x - fine.plan.active.x;  // fine index under the first coarse texel; may be -1
  channels::PlaneRow out{};
  for (int p = 0; p < planes_; ++p) out[static_cast<std::size_t>(p)] = row_at(coarse, y, p);
  for (int p = 0; p < planes_; ++p) {
    if (opaque && p == weight_plane_) {
      std::fill_n(out[static_cast<std::size_t>(p)], active.width, 1.0F);
    } else {
      halve_plane(fine, first, start, p, active.width, out[static_cast<std::size_t>(p)]);
    }
  }

  if (kernel_.is_point) {
    const float* weights = out[static_cast<std::size_t>(weight_plane_)];
    opaque = opaque || std::all_of(weights, weights + active.width, [](float w) { return w == 1.0F; });
  } else if (!opaque) {
    const std::int64_t x = 2 * active.x;
    opaque = channels::settle_coverage(planes_at(fine, 2 * y, x), planes_at(fine, 2 * y + 1, x), rules_, weight_plane_, active.width, out);
  }
  if (kernel_.limits_ringing) limit_to_neighbours(fine, y, active, opaque, out);
  coarse.opaque[static_cast<std::size_t>((y - active.y) % ring_rows_)] = opaque ? 1 : 0;
}

void PlaneCascade::halve_plane(LevelState& fine, std::int64_t first, std::int64_t start, int plane, std::int64_t count, float* out) {
  const auto texels = static_cast<std::size_t>(count);
  const std::int64_t middle = first + kernel_.reach();  // the upper of the two rows under the coarse one
  const float* upper = row_or_nothing(fine, middle, plane) + start;
  const float* lower = row_or_nothing(fine, middle + 1, plane) + start;
  switch (rules_[static_cast<std::size_t>(plane)]) {
    case PlaneRule::kLinear:
      break;
    case PlaneRule::kLeast:
      least_of_four(upper, lower, texels, out);
      return;
    case PlaneRule::kGreatest:
      greatest_of_four(upper, lower, texels, out);
      return;
  }
  if (kernel_.is_point) {
    pick_first(upper, texels, out);
    return;
  }
  if (kernel_.taps == 2) {
    halve_two_rows(upper, lower, kernel_, texels, out);
    return;
  }
  const float* rows[kMaxTaps];
  for (int t = 0; t < kernel_.taps; ++t) rows[t] = row_or_nothing(fine, first + t, plane) - kPad;
  combine_rows(rows, kernel_, static_cast<std::size_t>(fine.stride), combined_.data());
  halve_row(combined_.data() + kPad + start, kernel_, texels, scratch_.data(), out);
}

// Keeps every value between the least and the greatest of the 4 x 4 texels under the kernel's main lobe, so that its negative lobes sharpen
// edges but leave no rings beside them.
void PlaneCascade::limit_to_neighbours(LevelState& fine, std::int64_t y, const TexelRect& active, bool opaque,
                                       const channels::PlaneRow& out) {
  const std::int64_t start = 2 * active.x - fine.plan.active.x;
  if (!opaque) {
    const std::int64_t x = 2 * active.x;
    const std::array<channels::ConstPlaneRow, 4> rows{planes_at(fine, 2 * y - 1, x), planes_at(fine, 2 * y, x),
                                                      planes_at(fine, 2 * y + 1, x), planes_at(fine, 2 * y + 2, x)};
    channels::limit_to_covered(rows, rules_, weight_plane_, active.width, out);
    return;
  }
  for (int p = 0; p < planes_; ++p) {
    if (p == weight_plane_ || rules_[static_cast<std::size_t>(p)] != PlaneRule::kLinear) continue;
    const float* rows[4];
    for (int t = 0; t < 4; ++t) rows[t] = row_or_nothing(fine, 2 * y - 1 + t, p) + start;
    limit_to_four_rows(rows, static_cast<std::size_t>(active.width), combined_.data(), out[static_cast<std::size_t>(p)]);
  }
}

}  // namespace vt::pyramid
