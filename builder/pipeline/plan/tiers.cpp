#include "builder/pipeline/plan/tiers.h"

namespace vt::pipeline {

TexelRect Tier::block(std::int64_t index) const {
  return {(first_column + index % columns) * block_texels, (first_row + index / columns) * block_texels, block_texels, block_texels};
}

TileId Tier::carry_tile(std::int64_t index) const {
  return {Level{static_cast<std::uint8_t>(base.value - outputs)}, static_cast<std::uint32_t>(first_column + index % columns),
          static_cast<std::uint32_t>(first_row + index / columns)};
}

std::vector<Tier> plan_tiers(const LayerInfo& info, int levels) {
  std::vector<Tier> tiers;
  for (int base = info.finest.value; base >= 0; base -= levels) {
    Tier tier;
    tier.base = Level{static_cast<std::uint8_t>(base)};
    tier.has_carry = base >= levels;
    tier.outputs = tier.has_carry ? levels : base + 1;
    tier.data = info.data_rect(tier.base);
    tier.block_texels = std::int64_t{info.tile_texels()} << (tier.has_carry ? levels : base);
    tier.first_column = tier.data.x / tier.block_texels;
    tier.first_row = tier.data.y / tier.block_texels;
    tier.columns = (tier.data.right() + tier.block_texels - 1) / tier.block_texels - tier.first_column;
    tier.rows = (tier.data.bottom() + tier.block_texels - 1) / tier.block_texels - tier.first_row;
    tiers.push_back(tier);
    if (!tier.has_carry) break;
  }
  return tiers;
}

}  // namespace vt::pipeline
