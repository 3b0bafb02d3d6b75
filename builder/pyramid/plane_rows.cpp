#include "builder/pyramid/plane_rows.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>

namespace vt::pyramid {

using channels::PlaneRule;

float neutral_value(PlaneRule rule) {
  switch (rule) {
    case PlaneRule::kLinear:
    case PlaneRule::kRemainder:
      return 0.0F;
    case PlaneRule::kLeast:
      return std::numeric_limits<float>::infinity();
    case PlaneRule::kGreatest:
      return -std::numeric_limits<float>::infinity();
  }
  return 0.0F;
}

PlaneRows::PlaneRows(const BlockLevel& plan, const LayerShape& layer, std::span<const PlaneRule> rules, int rows, int reach)
    : plan_(plan),
      rules_(rules.begin(), rules.end()),
      rows_(rows),
      ends_in_x_(!layer.is_closed),
      wraps_(layer.wraps_at(plan.depth)),
      next_(plan.active.y) {
  runs_.push_back({plan.active, 0});
  stride_ = plan.active.width + 2 * kPad;
  if (!plan.beyond.empty()) {
    runs_.push_back({plan.beyond, stride_});
    stride_ += plan.beyond.width + 2 * kPad;
  }
  if (!ends_in_x_ && !wraps_) plan_seam(layer, reach);
  floats_.resize(static_cast<std::size_t>((rows_ + 1) * stride_) * rules_.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows_ + 1) * rules_.size(); ++row)
    std::fill_n(floats_.begin() + static_cast<std::ptrdiff_t>(row) * stride_, stride_, neutral_value(rules_[row % rules_.size()]));
  opaque_.assign(static_cast<std::size_t>(rows_), 0);
}

// Which texels of the pads show which columns of the runs.
void PlaneRows::plan_seam(const LayerShape& layer, std::int64_t reach) {
  const auto place_of = [&](std::int64_t column) -> std::optional<std::int64_t> {
    for (const ColumnRun& run : runs_)
      if (column >= run.rect.x && column < run.rect.right()) return run.at + column - run.rect.x;
    return std::nullopt;
  };
  const auto show = [&](const ColumnRun& run, std::int64_t column) {
    const SeamColumn seen = layer.column_past_edge(plan_.depth, column);
    const auto first = place_of(seen.first);
    const auto second = place_of(seen.second);
    if (first && second) seam_.push_back({run.at + column - run.rect.x, *first, *second, seen.share});
  };
  for (const ColumnRun& run : runs_)
    for (std::int64_t i = 0; i <= reach; ++i) {
      if (run.rect.x == 0) show(run, -1 - i);
      if (run.rect.right() == plan_.data.width) show(run, plan_.data.width + i);
    }
}

channels::PlaneRow PlaneRows::begin_row() {
  assert(!is_full());
  channels::PlaneRow planes{};
  for (std::size_t p = 0; p < rules_.size(); ++p) planes[p] = row(next_, static_cast<int>(p));
  return planes;
}

void PlaneRows::end_row(bool opaque) {
  const std::size_t slot = slot_of(next_);
  opaque_[slot] = opaque ? 1 : 0;
  if (!seam_.empty()) fill_pads(slot);
  ++next_;
}

// `values` and `remainders` are rows of one value in two planes; the first has the seam texel already.
float PlaneRows::remainder_of(const float* values, const float* remainders, const SeamTexel& texel) {
  const auto whole = [&](std::int64_t at) { return static_cast<double>(values[at]) + static_cast<double>(remainders[at]); };
  const double share = texel.share;
  const double value = (1.0 - share) * whole(texel.first) + share * whole(texel.second);
  return static_cast<float>(value - static_cast<double>(values[texel.at]));
}

void PlaneRows::fill_pads(std::size_t slot) {
  for (std::size_t p = 0; p < rules_.size(); ++p) {
    float* const row = floats_.data() + offset_of(slot, static_cast<int>(p));
    for (const SeamTexel& texel : seam_) {
      const float first = row[texel.first];
      const float second = row[texel.second];
      if (texel.share == 0.0F)
        row[texel.at] = first;
      else if (rules_[p] == PlaneRule::kLinear)
        row[texel.at] = (1.0F - texel.share) * first + texel.share * second;
      else if (rules_[p] == PlaneRule::kRemainder)
        row[texel.at] = remainder_of(row - stride_, row, texel);
      else
        row[texel.at] = rules_[p] == PlaneRule::kLeast ? std::min(first, second) : std::max(first, second);
    }
  }
}

channels::ConstPlaneRow PlaneRows::planes_or_nothing(std::int64_t y, std::int64_t place) const {
  channels::ConstPlaneRow planes{};
  for (std::size_t p = 0; p < rules_.size(); ++p) planes[p] = row_or_nothing(y, static_cast<int>(p)) + place;
  return planes;
}

}  // namespace vt::pyramid
