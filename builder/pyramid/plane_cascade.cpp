#include "builder/pyramid/plane_cascade.h"

#include <algorithm>
#include <cassert>

#include "builder/pyramid/plane_carry.h"

namespace vt::pyramid {

using channels::PlaneRow;

PlaneCascade::PlaneCascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs, const PlaneMeaning& planes,
                           const HalvingKernel& kernel, int tile_exponent)
    : Cascade(std::move(levels), outputs),
      layer_(layer),
      rules_(planes.rules.begin(), planes.rules.end()),
      weight_plane_(planes.weight_plane),
      tile_exponent_(tile_exponent) {
  assert(level_count() > 0 && !level(0).active.empty());
  if (planes.centre_range && !kernel.is_point) centres_.emplace(*planes.centre_range, rules_, weight_plane_);
  std::int64_t widest = 0;
  for (int k = 0; k < level_count(); ++k) {
    rows_.emplace_back(level(k), layer, rules_, PlaneHalver::rows_needed(kernel), kernel.reach());
    next_emitted_.push_back(level(k).core.y);
    widest = std::max(widest, rows_.back().stride());
  }
  halver_.emplace(rules_, weight_plane_, kernel, widest);
  if (!has_carry()) return;
  const auto edge = static_cast<std::size_t>(1) << tile_exponent_;
  for (const channels::PlaneRule rule : rules_) carry_.insert(carry_.end(), edge * edge, neutral_value(rule));
}

void PlaneCascade::end_row(bool opaque, RowSink& sink) {
  rows(0).end_row(opaque);
  row_is_written(0, sink);
}

void PlaneCascade::row_is_written(int k, RowSink& sink) {
  if (centres_ && k < outputs()) centres_->widen_bounds(rows(k), layer_, rows(k).next() - 1);
  emit_rows(k, sink);
  if (k + 1 == level_count()) return;
  PlaneRows& coarse = rows(k + 1);
  while (!coarse.is_full() && halver_->is_ready(rows(k), coarse)) {
    halver_->make_row(rows(k), coarse);
    row_is_written(k + 1, sink);
  }
}

void PlaneCascade::put_area_row(std::span<const channels::ClassAreaBlock* const>, std::int64_t, RowSink&) {
  assert(false && "only classes have areas");
}

// A row is passed on as soon as the one below it exists.
void PlaneCascade::emit_rows(int k, RowSink& sink) {
  const PlaneRows& here = rows(k);
  const TexelRect& core = here.plan().core;
  const std::int64_t ready = here.is_full() ? here.next() : here.next() - 1;
  std::int64_t& y = next_emitted_[static_cast<std::size_t>(k)];
  for (; y < std::min(ready, core.bottom()); ++y) {
    const std::int64_t place = core.x - here.plan().active.x;
    if (k == outputs()) {
      keep_carry_row(y, here.planes_or_nothing(y, place));
      continue;
    }
    channels::RowNeighbourhood found{here.planes_or_nothing(y - 1, place), here.planes_or_nothing(y, place),
                                     here.planes_or_nothing(y + 1, place), here.is_opaque(y)};
    if (centres_) centres_->move(here, layer_, y, core.x, core.width, at_centres_, found.here);
    sink.row(k, y, found);
  }
}

void PlaneCascade::keep_carry_row(std::int64_t y, const channels::ConstPlaneRow& row) {
  const TexelRect& core = level(outputs()).core;
  const auto edge = std::int64_t{1} << tile_exponent_;
  for (std::int64_t p = 0; p < static_cast<std::int64_t>(rules_.size()); ++p)
    std::copy_n(row[static_cast<std::size_t>(p)], core.width,
                carry_.begin() + (p * edge + (y & (edge - 1))) * edge + (core.x & (edge - 1)));
}

void PlaneCascade::carry_bytes(std::vector<std::byte>& out) const {
  pack_carry(carry_, rules_.size(), static_cast<std::size_t>(1) << tile_exponent_, out);
}

Result<void> PlaneCascade::feed_carry(const CarryTiles& carry, RowSink& sink) {
  const auto edge = std::int64_t{1} << tile_exponent_;
  const auto plane_floats = static_cast<std::size_t>(edge * edge);
  const std::size_t tile_floats = rules_.size() * plane_floats;
  carry_read_.resize(carry.tiles.size() * tile_floats);
  for (std::size_t i = 0; i < carry.tiles.size(); ++i) {
    const auto tile = std::span(carry_read_).subspan(i * tile_floats, tile_floats);
    if (carry.tiles[i].empty()) {
      for (std::size_t p = 0; p < rules_.size(); ++p)
        std::ranges::fill(tile.subspan(p * plane_floats, plane_floats), neutral_value(rules_[p]));
    } else {
      VT_CHECK(unpack_carry(carry.tiles[i], rules_.size(), static_cast<std::size_t>(edge), tile));
    }
  }

  // `count` texels of row `y` from column `x` on, all in one tile.
  const auto copy = [&](std::int64_t x, std::int64_t y, std::int64_t count, const PlaneRow& out, std::int64_t place) {
    const auto tile = std::lower_bound(carry.columns.begin(), carry.columns.end(), x >> tile_exponent_) - carry.columns.begin();
    const float* const floats = carry_read_.data() + static_cast<std::size_t>(tile) * tile_floats;
    for (std::int64_t p = 0; p < static_cast<std::int64_t>(rules_.size()); ++p)
      std::copy_n(floats + (p * edge + (y & (edge - 1))) * edge + (x & (edge - 1)), count, out[static_cast<std::size_t>(p)] + place);
  };
  const BlockLevel& base = level(0);
  const std::int64_t end_row = std::min((carry.row + 1) * edge, base.active.bottom());
  for (std::int64_t y = std::max(carry.row * edge, base.active.y); y < end_row; ++y) {
    const PlaneRow planes = begin_row();
    bool opaque = true;
    for (const ColumnRun& run : rows(0).runs()) {
      for (const WrappedPart& part : wrapped_parts(run.rect, base.data))
        for (std::int64_t x = part.rect.x; x < part.rect.right();) {
          const std::int64_t count = std::min(((x >> tile_exponent_) + 1) << tile_exponent_, part.rect.right()) - x;
          copy(x, y, count, planes, run.at + part.offset + (x - part.rect.x));
          x += count;
        }
      const float* const weights = planes[static_cast<std::size_t>(weight_plane_)] + run.at;
      opaque = opaque && std::all_of(weights, weights + run.rect.width, [](float w) { return w == 1.0F; });
    }
    this->end_row(opaque, sink);
  }
  return {};
}

}  // namespace vt::pyramid
