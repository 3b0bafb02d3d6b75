#include "builder/pipeline/plan/work_map.h"

#include <algorithm>

namespace vt::pipeline {
namespace {

// The tier's blocks that have any part in `texels` of its base level, as a rectangle counted in blocks.
TexelRect blocks_over(const Tier& tier, const TexelRect& texels) {
  const TexelRect inside = intersect(texels, tier.data);
  if (inside.empty()) return {};
  const std::int64_t x0 = inside.x / tier.block_texels;
  const std::int64_t y0 = inside.y / tier.block_texels;
  return {x0, y0, (inside.right() - 1) / tier.block_texels - x0 + 1, (inside.bottom() - 1) / tier.block_texels - y0 + 1};
}

}  // namespace

WorkMap::WorkMap(const LayerPlan& plan, int block_levels) : plan_(plan), tiers_(plan_tiers(plan.info, block_levels)) {
  for (const Tier& tier : tiers_) {
    const TexelRect core = tier.block(0);
    const TexelRect everything = grown(core, tier.block_texels * 4);  // no data edge cuts the apron
    aprons_.push_back(core.x - pyramid::plan_block(core, everything, tier.outputs, tier.has_carry, plan.kernel).front().active.x);
  }
}

// At least as many texels of a tier's base as its blocks see past the seam of a closed layer. A column past
// the edge lies between two and widths may be odd, so each level asks for up to two more than its apron, and
// the next finer one for twice as many: for less than two texels of the level above the tier.
std::int64_t WorkMap::seam_apron(std::size_t tier) const {
  return aprons_[tier] + 2 * (tiers_[tier].block_texels >> plan_.info.tile_exponent) + 2;
}

std::vector<pyramid::BlockLevel> WorkMap::plan_block(std::size_t tier, std::int64_t index) const {
  const Tier& t = tiers_[tier];
  return pyramid::plan_block(t.block(index), plan_.shape(), plan_.info.finest.value - t.base.value, t.outputs, t.has_carry, plan_.kernel);
}

TexelRect WorkMap::active(std::size_t tier, std::int64_t index) const {
  if (plan_.is_closed) return plan_block(tier, index).front().active;
  return intersect(grown(tiers_[tier].block(index), aprons_[tier]), tiers_[tier].data);
}

// All texels of the finest level on which the block may depend.
std::vector<TexelRect> WorkMap::seen(std::size_t tier, std::int64_t index) const {
  const Tier& t = tiers_[tier];
  const int steps = plan_.info.finest.value - t.base.value;
  if (!plan_.is_closed) return {intersect(finer(active(tier, index), steps), plan_.info.data)};
  TexelRect base = grown(intersect(t.block(index), t.data), seam_apron(tier));
  base = intersect(base, {base.x, t.data.y, base.width, t.data.height});
  TexelRect finest = finer(base, steps);
  finest = intersect(finest, {finest.x, plan_.info.data.y, finest.width, plan_.info.data.height});
  std::vector<TexelRect> parts;
  for (const pyramid::WrappedPart& part : pyramid::wrapped_parts(finest, plan_.info.data)) parts.push_back(part.rect);
  return parts;
}

bool WorkMap::is_touched(std::size_t tier, std::int64_t index) const {
  return std::ranges::any_of(seen(tier, index),
                             [&](const TexelRect& rect) { return plan_.sampler->touches(from_corner_of(plan_.info.data, rect)); });
}

std::vector<std::int64_t> WorkMap::touched(std::size_t tier) const {
  std::vector<std::int64_t> found;
  const Tier& top = tiers_.back();
  collect(tiers_.size() - 1, {top.first_column, top.first_row, top.columns, top.rows}, tier, found);
  std::sort(found.begin(), found.end());
  return found;
}

// A block's apron reaches farther than that of the finer blocks inside it, so nothing is lost by looking only
// under touched blocks.
void WorkMap::collect(std::size_t tier, const TexelRect& blocks, std::size_t wanted, std::vector<std::int64_t>& out) const {
  for (std::int64_t row = blocks.y; row < blocks.bottom(); ++row)
    for (std::int64_t column = blocks.x; column < blocks.right(); ++column) {
      const std::int64_t index = tiers_[tier].index_of(column, row);
      if (!is_touched(tier, index)) continue;
      if (tier == wanted) {
        out.push_back(index);
        continue;
      }
      const Tier& below = tiers_[tier - 1];
      const TexelRect core = intersect(tiers_[tier].block(index), tiers_[tier].data);
      const int steps = below.base.value - tiers_[tier].base.value;
      collect(tier - 1, blocks_over(below, finer(core, steps)), wanted, out);
    }
}

std::vector<std::int64_t> WorkMap::dependents(std::size_t tier, std::int64_t index) const {
  std::vector<std::int64_t> found;
  if (tier + 1 == tiers_.size()) return found;
  const Tier& next = tiers_[tier + 1];
  // The block's carry is one tile of the next tier's base level.
  const TexelRect carry = rect_of(tiers_[tier].carry_tile(index), plan_.info.tile_exponent);
  const auto add = [&](const TexelRect& readers) {
    const TexelRect blocks = blocks_over(next, readers);
    for (std::int64_t row = blocks.y; row < blocks.bottom(); ++row)
      for (std::int64_t column = blocks.x; column < blocks.right(); ++column) found.push_back(next.index_of(column, row));
  };
  if (!plan_.is_closed) {
    add(grown(carry, aprons_[tier + 1]));
    return found;
  }
  // Also from across the seam.
  const TexelRect seen = grown(intersect(carry, next.data), seam_apron(tier + 1));
  for (const std::int64_t turn : {-next.data.width, std::int64_t{0}, next.data.width})
    add({seen.x + turn, seen.y, seen.width, seen.height});
  std::ranges::sort(found);
  const auto repeated = std::ranges::unique(found);
  found.erase(repeated.begin(), repeated.end());
  return found;
}

std::uint64_t WorkMap::core_texels(std::size_t tier, std::int64_t index) const {
  const TexelRect core = intersect(tiers_[tier].block(index), tiers_[tier].data);
  return static_cast<std::uint64_t>(core.width) * static_cast<std::uint64_t>(core.height);
}

}  // namespace vt::pipeline
