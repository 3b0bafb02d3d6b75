// Small stores with known texels, written straight through StoreWriter: what vtinspect's tests look at.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "store/layer.h"
#include "store/tile_id.h"

namespace vt::test {

// Both layers lie over 400 m x 240 m in UTM 33N, their west edge on the central meridian.
//   "color"      rgb8, sRGB, 40 x 24 texels of 10 m at 4,8 in a 64 x 64 square, tiles of 16, levels 0..2
//   "elevation"  r32f, 20 x 12 texels of 20 m at 0,0 in a 32 x 32 square, tiles of 16, levels 0..1, nodata -9999, a hole at finest texel
//   3,2
inline constexpr double kWest = 500000.0;
inline constexpr double kNorth = 5000000.0;
inline constexpr TexelRect kColorData{4, 8, 40, 24};
inline constexpr TexelRect kElevationData{0, 0, 20, 12};

// The values of texels, counted in the padded square of their level.
std::uint8_t color_code(Level level, std::int64_t x, std::int64_t y, int channel);
float elevation_m(Level level, std::int64_t x, std::int64_t y);

struct SampleStore {
  bool with_elevation = true;
  bool with_carry = false;                   // "color.carry", r32f, root only
  std::optional<TileId> absent_color_tile;   // left out
  std::optional<TileId> changed_color_tile;  // its first red code is 2 higher
  TexelFormat color_format = TexelFormat::kRgb8;
  std::string color_name = "color";
};
void write_sample_store(const std::filesystem::path& path, const SampleStore& options = {});

// Turns over one bit of a byte of the file.
void flip_bit(const std::filesystem::path& path, std::uint64_t offset);
// Where the record of a tile starts in the file. Its 768 bytes of texels follow a header of less than 100.
std::uint64_t tile_offset(const std::filesystem::path& path, const std::string& layer, TileId tile);

}  // namespace vt::test
