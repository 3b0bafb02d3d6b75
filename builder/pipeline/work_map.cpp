#include "builder/pipeline/work_map.h"

#include <algorithm>

#include "builder/pyramid/cascade.h"

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

TexelRect WorkMap::active(std::size_t tier, std::int64_t index) const {
  return intersect(grown(tiers_[tier].block(index), aprons_[tier]), tiers_[tier].data);
}

bool WorkMap::is_touched(std::size_t tier, std::int64_t index) const {
  const int steps = plan_.info.finest.value - tiers_[tier].base.value;
  const TexelRect base = active(tier, index);
  const TexelRect finest = intersect(finer(base, steps), plan_.info.data);
  return plan_.sampler->touches(from_corner_of(plan_.info.data, finest));
}

std::vector<std::int64_t> WorkMap::touched(std::size_t tier) const {
  std::vector<std::int64_t> found;
  const Tier& top = tiers_.back();
  collect(tiers_.size() - 1, {top.first_column, top.first_row, top.columns, top.rows}, tier, found);
  std::sort(found.begin(), found.end());
  return found;
}

// A block's apron reaches farther than that of the finer blocks inside it, so nothing is lost by looking only under touched blocks.
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
  const TexelRect blocks = blocks_over(next, grown(carry, aprons_[tier + 1]));
  for (std::int64_t row = blocks.y; row < blocks.bottom(); ++row)
    for (std::int64_t column = blocks.x; column < blocks.right(); ++column) found.push_back(next.index_of(column, row));
  return found;
}

std::uint64_t WorkMap::core_texels(std::size_t tier, std::int64_t index) const {
  const TexelRect core = intersect(tiers_[tier].block(index), tiers_[tier].data);
  return static_cast<std::uint64_t>(core.width) * static_cast<std::uint64_t>(core.height);
}

}  // namespace vt::pipeline
