// Names of places in a pyramid: levels, tiles, rectangles of texels. Coordinates are types, so that a swapped
// pair does not compile. Level 0 is the coarsest (one tile over everything); each next level halves the
// ground sample distance.
#pragma once

#include <compare>
#include <cstdint>

namespace vt {

inline constexpr int kMaxTileExponent = 12;  // tiles of 4 to 4096 texels
inline constexpr int kMinTileExponent = 2;
inline constexpr int kMaxVtExponent = 31;  // the finest level is at most 2^31 texels wide in its padded square

struct Level {
  std::uint8_t value = 0;
  auto operator<=>(const Level&) const = default;
};

// The virtual-texture paper counts from the finest level (0 = finest). This is its own inverse given
// `finest`.
[[nodiscard]] constexpr int paper_level(Level level, Level finest) { return int{finest.value} - int{level.value}; }
[[nodiscard]] constexpr Level level_from_paper(int paper, Level finest) {
  return Level{static_cast<std::uint8_t>(int{finest.value} - paper)};
}

struct TileId {
  Level level;
  std::uint32_t x = 0;  // columns from the west edge of the padded square
  std::uint32_t y = 0;  // rows from its north edge
  auto operator<=>(const TileId&) const = default;
};

[[nodiscard]] constexpr TileId parent_of(TileId tile) {
  return {Level{static_cast<std::uint8_t>(tile.level.value - 1)}, tile.x / 2, tile.y / 2};
}

// A rectangle of texels of one level, in the padded square; x to the east, y to the south. Signed, because
// aprons reach outside.
struct TexelRect {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  auto operator<=>(const TexelRect&) const = default;

  [[nodiscard]] constexpr std::int64_t right() const { return x + width; }    // first column outside
  [[nodiscard]] constexpr std::int64_t bottom() const { return y + height; }  // first row outside
  [[nodiscard]] constexpr bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] constexpr bool contains(std::int64_t px, std::int64_t py) const {
    return px >= x && px < right() && py >= y && py < bottom();
  }
};

[[nodiscard]] constexpr TexelRect intersect(const TexelRect& a, const TexelRect& b) {
  const std::int64_t x0 = a.x > b.x ? a.x : b.x;
  const std::int64_t y0 = a.y > b.y ? a.y : b.y;
  const std::int64_t x1 = a.right() < b.right() ? a.right() : b.right();
  const std::int64_t y1 = a.bottom() < b.bottom() ? a.bottom() : b.bottom();
  return {x0, y0, x1 > x0 ? x1 - x0 : 0, y1 > y0 ? y1 - y0 : 0};
}

// `by` texels more on every side.
[[nodiscard]] constexpr TexelRect grown(const TexelRect& rect, std::int64_t by) {
  return {rect.x - by, rect.y - by, rect.width + 2 * by, rect.height + 2 * by};
}

// The same rectangle counted from another's north-west corner.
[[nodiscard]] constexpr TexelRect from_corner_of(const TexelRect& origin, const TexelRect& rect) {
  return {rect.x - origin.x, rect.y - origin.y, rect.width, rect.height};
}

// The texels of a level `steps` finer that `rect` covers.
[[nodiscard]] constexpr TexelRect finer(const TexelRect& rect, int steps) {
  return {rect.x << steps, rect.y << steps, rect.width << steps, rect.height << steps};
}

// The texels of a level `steps` coarser that have any part in `rect`. Rounds outward, also for negative
// coordinates.
[[nodiscard]] constexpr TexelRect coarser(const TexelRect& rect, int steps) {
  const std::int64_t x0 = rect.x >> steps;
  const std::int64_t y0 = rect.y >> steps;
  const std::int64_t round = (std::int64_t{1} << steps) - 1;
  return {x0, y0, ((rect.right() + round) >> steps) - x0, ((rect.bottom() + round) >> steps) - y0};
}

// Where a tile lies on its level.
[[nodiscard]] constexpr TexelRect rect_of(TileId tile, int tile_exponent) {
  const std::int64_t size = std::int64_t{1} << tile_exponent;
  return {std::int64_t{tile.x} << tile_exponent, std::int64_t{tile.y} << tile_exponent, size, size};
}

}  // namespace vt
