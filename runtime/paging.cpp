#include "runtime/paging.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace vt::runtime {
namespace {

constexpr int kMaxTilesPerSide = 8;
constexpr int kMaxTileTextureExponent = 13;

// Position along one axis, in texels.
std::int64_t axis_origin(double center, std::int64_t box, std::int64_t width, std::int64_t data_begin, std::int64_t data_end,
                         std::int64_t hop, const std::int64_t* current, double hysteresis) {
  // The box may travel over the data, rounded out to the grid; where the data is smaller than the box there
  // is nowhere to go.
  const std::int64_t first = std::min(data_begin / hop * hop, width - box);
  const std::int64_t last = std::max(first, std::min((data_end + hop - 1) / hop * hop, width) - box);

  const double wish = std::clamp(center - 0.5 * static_cast<double>(box), static_cast<double>(first), static_cast<double>(last));
  if (current != nullptr && *current >= first && *current <= last) {
    const double keep = (0.5 + hysteresis) * static_cast<double>(hop);
    if (std::abs(wish - static_cast<double>(*current)) <= keep) return *current;
  }
  return static_cast<std::int64_t>(std::floor(wish / static_cast<double>(hop) + 0.5)) * hop;
}

int log2_floor(std::int64_t value) { return std::bit_width(static_cast<std::uint64_t>(value)) - 1; }

}  // namespace

Linear local_transform(double center, int tile, int paper_level, int vt, double origin) {
  const double scale = std::ldexp(1.0, vt - paper_level - tile);
  return {scale, 0.5 + scale * (origin - center)};
}

Box union_of(const Box& a, const Box& b) {
  return {std::min(a.s_min, b.s_min), std::min(a.t_min, b.t_min), std::max(a.s_max, b.s_max), std::max(a.t_max, b.t_max)};
}

Result<VtLayout> make_layout(const LayerInfo& layer, const LayoutOptions& options) {
  const int block_exponent = log2_floor(format_info(layer.format).block_edge);
  VtLayout layout{.vt_exponent = layer.vt_exponent(),
                  .store_tile_exponent = layer.tile_exponent,
                  .finest = layer.finest,
                  .data = layer.data,
                  .levels = {}};

  // The coarsest level that is kept is the finest one that a single tile holds; a store whose root tile is
  // larger still is held whole.
  const int coarsest = std::clamp(options.tile_exponent - int{layer.tile_exponent}, 0, int{layer.finest.value});
  for (int value = layer.finest.value; value >= coarsest; --value) {
    const Level level{static_cast<std::uint8_t>(value)};
    const int level_exponent = layer.tile_exponent + value;
    int tile_exponent = options.tile_exponent;
    int tiles_per_side = options.tiles_per_side;
    int mips = options.mips;
    std::int64_t hop = options.hop_texels;
    for (const LayoutOptions::Override& o : options.overrides) {
      if (o.level != level) continue;
      if (o.tile_exponent >= 1) tile_exponent = o.tile_exponent;
      if (o.tiles_per_side >= 1) tiles_per_side = o.tiles_per_side;
      if (o.mips >= 1) mips = o.mips;
      if (o.hop_texels >= 1) hop = o.hop_texels;
    }
    if (tile_exponent < 3 || tile_exponent > kMaxTileTextureExponent)
      return fail(ErrorCode::kUsage, "tile textures are 8 to 8192 texels wide; 2^" + std::to_string(tile_exponent) + " was asked for");
    if (tiles_per_side < 1 || tiles_per_side > kMaxTilesPerSide)
      return fail(ErrorCode::kUsage, "a level is 1x1 to 8x8 tiles; " + std::to_string(tiles_per_side) + " a side were asked for");
    if (hop < 0 || !std::has_single_bit(static_cast<std::uint64_t>(std::max<std::int64_t>(hop, 1))))
      return fail(ErrorCode::kUsage, "the paging grid is a power of two; " + std::to_string(hop) + " texels were asked for");

    if (value == coarsest) {
      tile_exponent = level_exponent;
      tiles_per_side = 1;
      hop = 0;
    }
    if (value != coarsest && options.levels > 0 && value <= int{layer.finest.value} - options.levels) continue;
    tile_exponent = std::min(tile_exponent, level_exponent);
    tiles_per_side = static_cast<int>(std::min<std::int64_t>(tiles_per_side, std::int64_t{1} << (level_exponent - tile_exponent)));
    const std::int64_t tile = std::int64_t{1} << tile_exponent;
    if (hop == 0) hop = tiles_per_side == 1 && tile_exponent < level_exponent ? tile / 2 : tile;
    hop = std::clamp<std::int64_t>(hop, std::int64_t{1} << block_exponent, tile);

    // Mip k of a tile is a rectangle of the level k coarser; it lies on that level's texels (or blocks) only
    // when 2^k divides the tile's origin.
    const int mips_on_grid = log2_floor(hop) - block_exponent + 1;
    const int mips_in_store = value + 1;
    const int most = std::max(1, std::min(mips_on_grid, mips_in_store));
    mips = mips == 0 ? most : std::min(mips, most);
    layout.levels.push_back({.level = level, .tile_exponent = tile_exponent, .tiles_per_side = tiles_per_side, .mips = mips, .hop = hop});
  }
  return layout;
}

TexelOrigin box_origin(const VtLayout& layout, const LevelLayout& level, double s, double t, const TexelOrigin* current,
                       double hysteresis) {
  const std::int64_t width = layout.width(level.level);
  const TexelRect data = coarser(layout.data, layout.finest.value - level.level.value);
  const double texels = static_cast<double>(width);
  return {axis_origin(s * texels, level.box_texels(), width, data.x, data.right(), level.hop, current ? &current->x : nullptr, hysteresis),
          axis_origin((1.0 - t) * texels, level.box_texels(), width, data.y, data.bottom(), level.hop, current ? &current->y : nullptr,
                      hysteresis)};
}

Box box_at(const VtLayout& layout, Level level, TexelOrigin origin, std::int64_t texels) {
  const double scale = std::ldexp(1.0, -(layout.store_tile_exponent + level.value));
  const std::int64_t width = layout.width(level);
  // Rows are turned round while they are integers, so both ends are exact.
  return {static_cast<double>(origin.x) * scale, static_cast<double>(width - origin.y - texels) * scale,
          static_cast<double>(origin.x + texels) * scale, static_cast<double>(width - origin.y) * scale};
}

Point2 center_of(const VtLayout& layout, const LevelLayout& level, TexelOrigin tile) {
  const double scale = std::ldexp(1.0, -(layout.store_tile_exponent + level.level.value));
  const std::int64_t half = level.tile_texels() / 2;
  return {static_cast<double>(tile.x + half) * scale, static_cast<double>(layout.width(level.level) - tile.y - half) * scale};
}

TileMatrix tile_matrix(const VtLayout& layout, const LevelLayout& level, TexelOrigin tile, const VtMapping::Affine& st_from_uv,
                       Point2 uv_origin) {
  const int paper = paper_level(level.level, layout.finest);
  const Point2 center = center_of(layout, level, tile);
  const Linear u =
      local_transform(center.x, level.tile_exponent, paper, layout.vt_exponent, st_from_uv.scale_x * uv_origin.x + st_from_uv.offset_x);
  const Linear v =
      local_transform(center.y, level.tile_exponent, paper, layout.vt_exponent, st_from_uv.scale_y * uv_origin.y + st_from_uv.offset_y);
  return {.scale_x = u.scale * st_from_uv.scale_x, .scale_y = -v.scale * st_from_uv.scale_y, .trans_x = u.trans, .trans_y = 1.0 - v.trans};
}

}  // namespace vt::runtime
