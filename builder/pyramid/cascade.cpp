#include "builder/pyramid/cascade.h"

#include <algorithm>

namespace vt::pyramid {
namespace {

// Plans the columns of a closed layer's levels, from the coarsest to the finest: each level asks the next
// finer one for what lies under it and under its kernel.
class ClosedColumns {
 public:
  ClosedColumns(const LayerShape& layer, std::int64_t reach) : layer_(layer), reach_(reach) {}

  // The level has its core; `apron` is the least that it needs around it.
  void plan(BlockLevel& level, std::int64_t apron) {
    wanted_.west = std::min(wanted_.west, level.core.x - apron);
    wanted_.east = std::max(wanted_.east, level.core.right() + apron);
    if (layer_.wraps_at(level.depth)) {
      set_columns(level.active, wanted_.west, wanted_.east);
    } else {
      plan_ends(level);
    }
    if (level.depth > 0) want_finer(level);
  }

 private:
  struct Wanted {
    std::int64_t west = INT64_MAX;  // columns from west to east, which may count on past the edges
    std::int64_t east = INT64_MIN;
    std::int64_t at_west_end = 0;  // so many of the first columns, as seen from across the seam
    std::int64_t at_east_end = 0;  // likewise of the last
  };

  static void set_columns(TexelRect& rect, std::int64_t west, std::int64_t east) {
    rect.x = west;
    rect.width = east - west;
  }

  // A column past the edge of a level that does not wrap lies between two at the other end.
  void plan_ends(BlockLevel& level) {
    const std::int64_t width = level.data.width;
    if (wanted_.east > width) wanted_.at_west_end = std::max(wanted_.at_west_end, wanted_.east - width + 1);
    if (wanted_.west < 0) wanted_.at_east_end = std::max(wanted_.at_east_end, 1 - wanted_.west);
    const std::int64_t west = std::max<std::int64_t>(wanted_.west, 0);
    const std::int64_t east = std::min(wanted_.east, width);
    const bool meets_west_end = wanted_.at_west_end > 0 && wanted_.at_west_end >= west;
    const bool meets_east_end = wanted_.at_east_end > 0 && width - wanted_.at_east_end <= east;
    level.beyond = level.active;
    if (meets_west_end || meets_east_end || (wanted_.at_west_end > 0 && wanted_.at_east_end > 0)) {
      set_columns(level.active, 0, width);
      set_columns(level.beyond, 0, 0);
      wanted_.at_west_end = wanted_.at_east_end = 0;
    } else {
      set_columns(level.active, west, east);
      if (wanted_.at_east_end > 0)
        set_columns(level.beyond, width - wanted_.at_east_end, width);
      else
        set_columns(level.beyond, 0, wanted_.at_west_end);
    }
  }

  void want_finer(const BlockLevel& level) {
    Wanted finer{2 * level.active.x - reach_, 2 * level.active.right() + reach_};
    const std::int64_t west_end = wanted_.at_west_end > 0 ? 2 * wanted_.at_west_end + reach_ : 0;
    const std::int64_t east_end = wanted_.at_east_end > 0 ? 2 * wanted_.at_east_end + reach_ : 0;
    if (!layer_.wraps_at(level.depth - 1)) {
      finer.at_west_end = west_end;
      finer.at_east_end = east_end;
    } else {
      // There the other end follows without a gap.
      const std::int64_t period = layer_.data_at(level.depth - 1).width;
      if (west_end > 0) finer.east = std::max(finer.east, period + west_end);
      if (east_end > 0) finer.west = std::min(finer.west, -east_end);
    }
    wanted_ = finer;
  }

  const LayerShape& layer_;
  std::int64_t reach_;
  Wanted wanted_;
};

}  // namespace

std::vector<BlockLevel> plan_block(const TexelRect& core, const LayerShape& layer, int depth, int outputs, bool with_carry,
                                   const HalvingKernel& kernel) {
  const int count = outputs + (with_carry ? 1 : 0);
  std::vector<BlockLevel> levels(static_cast<std::size_t>(count));
  ClosedColumns closed(layer, kernel.reach());
  std::int64_t apron = 0;
  for (int k = count - 1; k >= 0; --k) {
    // A level that becomes texels needs one more texel around it, for colour borrowed from neighbours; a
    // carry level does not.
    const std::int64_t least = k < outputs ? 1 : 0;
    apron = std::max(apron, least);
    BlockLevel& level = levels[static_cast<std::size_t>(k)];
    const TexelRect core_k{core.x >> k, core.y >> k, core.width >> k, core.height >> k};
    level.depth = depth + k;
    level.data = layer.data_at(level.depth);
    level.core = intersect(core_k, level.data);
    level.active = intersect(grown(core_k, apron), level.data);
    if (layer.is_closed && !level.core.empty()) closed.plan(level, least);
    apron = 2 * apron + kernel.reach();  // what the next finer level must have around its core
  }
  return levels;
}

std::vector<std::int64_t> carry_columns(const BlockLevel& base, int tile_exponent) {
  std::vector<std::int64_t> columns;
  const auto add = [&](const TexelRect& rect) {
    for (const WrappedPart& part : wrapped_parts(rect, base.data))
      for (std::int64_t column = part.rect.x >> tile_exponent; column <= (part.rect.right() - 1) >> tile_exponent; ++column)
        columns.push_back(column);
  };
  add(base.active);
  if (!base.beyond.empty()) add(base.beyond);
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

}  // namespace vt::pyramid
