#include "builder/pipeline/blocks/block_marks.h"

#include <algorithm>
#include <array>

namespace vt::pipeline {
namespace {

// The smallest tile there is, since its value is the same everywhere.
constexpr std::uint8_t kMarkTileExponent = kMinTileExponent;

// A block's mark lies where its carry tile lies. A block that is the whole layer has no carry and is alone.
TileId mark_tile(const Tier& tier, std::int64_t index) { return tier.has_carry ? tier.carry_tile(index) : TileId{}; }

}  // namespace

store::ContentHash carry_mark() {
  store::ContentHash mark;
  mark.bytes.fill(std::byte{0xFF});
  return mark;
}

LayerInfo BlockMarks::describe(const LayerPlan& plan, int block_levels) {
  const Tier first = plan_tiers(plan.info, block_levels).front();
  LayerInfo info = plan.info;
  info.name = plan.info.name + "/sources";
  info.role = LayerRole::kCarry;
  info.format = TexelFormat::kHash128;
  info.transfer = Transfer::kLinear;
  info.metadata_json = "{}";
  info.components = {};
  info.zero_is_nodata = false;
  info.is_point_sampled = false;
  info.tile_exponent = kMarkTileExponent;
  info.finest = Level{static_cast<std::uint8_t>(first.has_carry ? first.base.value - first.outputs : 0)};
  // Each block is one tile of this layer, so its texels are 2^kMarkTileExponent to a block.
  const std::int64_t edge = std::int64_t{1} << kMarkTileExponent;
  const double texels = static_cast<double>(first.block_texels / edge);
  info.data = {first.first_column * edge, first.first_row * edge, first.columns * edge, first.rows * edge};
  // The first block may begin outside the layer's data.
  info.grid.origin_x -= static_cast<double>(plan.info.data.x - first.first_column * first.block_texels) * plan.info.grid.step_x;
  info.grid.origin_y += static_cast<double>(plan.info.data.y - first.first_row * first.block_texels) * plan.info.grid.step_y;
  info.grid.step_x = plan.info.grid.step_x * texels;
  info.grid.step_y = plan.info.grid.step_y * texels;
  return info;
}

namespace {

Result<std::optional<store::ContentHash>> mark_at(const store::StoreWriter& writer, LayerId layer, TileId tile) {
  if (!writer.contains(layer, tile)) return std::nullopt;
  constexpr std::size_t kEdge = std::size_t{1} << kMarkTileExponent;
  std::array<std::byte, kEdge * kEdge * sizeof(store::ContentHash::bytes)> texels;
  VT_CHECK(writer.read(layer, tile, texels));
  store::ContentHash hash;
  std::copy_n(texels.begin(), hash.bytes.size(), hash.bytes.begin());
  return hash;
}

}  // namespace

Result<std::optional<store::ContentHash>> BlockMarks::find(const Tier& tier, std::int64_t index) const {
  return mark_at(writer_, layer_, mark_tile(tier, index));
}

Result<void> BlockMarks::set(const Tier& tier, std::int64_t index, const store::ContentHash& hash) {
  return writer_.put_constant(layer_, mark_tile(tier, index), hash.bytes);
}

Result<void> BlockMarks::begin(const Tier& tier, std::int64_t index) {
  return writer_.contains(layer_, mark_tile(tier, index)) ? Result<void>() : set(tier, index, kStaleMark);
}

Result<bool> BlockMarks::any_built(const store::StoreWriter& writer, const LayerInfo& layer) {
  if (layer.role != LayerRole::kCarry || layer.format != TexelFormat::kHash128) return false;
  for (std::uint8_t level = 0; level <= layer.finest.value; ++level) {
    VT_ASSIGN(std::optional<TileId> tile, writer.next_tile(layer.id, Level{level}, std::nullopt));
    while (tile) {
      VT_ASSIGN(const auto mark, mark_at(writer, layer.id, *tile));
      if (mark && *mark != kStaleMark) return true;
      VT_ASSIGN(tile, writer.next_tile(layer.id, Level{level}, tile));
    }
  }
  return false;
}

}  // namespace vt::pipeline
