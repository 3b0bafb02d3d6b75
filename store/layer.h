// A layer: one virtual texture in a store. A store holds many layers over one area; they may differ in everything but that area.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <string>

#include "store/channel.h"
#include "store/texel_format.h"
#include "store/tile_id.h"

namespace vt {

struct LayerId {
  std::uint16_t value = 0;
  auto operator<=>(const LayerId&) const = default;
};

// Numbers are on disk.
enum class LayerRole : std::uint8_t {
  kTexture = 0,  // what applications read
  kCarry = 1,    // unquantised filter state of the `owner` layer, kept so that a build can resume and update; readers may ignore it
};
enum class LayerState : std::uint8_t {
  kBuilding = 0,  // tiles are missing because the build has not come to them
  kComplete = 1,  // an absent tile has no data
};

// The rectangle of the dataset in the units of its coordinate reference system; (u, v) run 0..1 over it from the south-west corner.
struct Area {
  double west = 0.0;
  double south = 0.0;
  double east = 1.0;
  double north = 1.0;
  auto operator<=>(const Area&) const = default;
};

// The layer's finest grid on the ground. Coordinates of texel edges are always origin + i * step, never a running sum.
struct GridPlacement {
  double origin_x = 0.0;  // outer north-west corner of the data rectangle, CRS units
  double origin_y = 0.0;
  double step_x = 1.0;  // CRS units per finest texel, to the east; > 0
  double step_y = 1.0;  // CRS units per finest texel, to the south; > 0 for a north-up grid
  auto operator<=>(const GridPlacement&) const = default;
};

struct LayerInfo {
  LayerId id;        // given by the store
  std::string name;  // 1..63 bytes of UTF-8, unique in the store
  ChannelType channel = ChannelType::kColor;
  TexelFormat format = TexelFormat::kRgb8;
  Transfer transfer = Transfer::kLinear;
  LayerRole role = LayerRole::kTexture;
  LayerState state = LayerState::kBuilding;
  LayerId owner;  // for kCarry: the layer it belongs to
  std::uint8_t tile_exponent = 8;
  Level finest;    // the padded square is 2^(finest + tile_exponent) texels wide at this level
  TexelRect data;  // finest-level texels that the source covers, inside the padded square
  GridPlacement grid;
  // What "no data" was called in the source, so that `extract` can give it back; NaN when the source had none.
  double source_nodata = std::numeric_limits<double>::quiet_NaN();
  std::string metadata_json;  // for tools; the runtime does not read it

  // Kept by the store.
  std::uint64_t tiles = 0;  // entries present, constants included
  std::uint64_t constant_tiles = 0;
  std::uint64_t stored_bytes = 0;  // bytes of tile records that the index points to; shared records count once per tile

  [[nodiscard]] int vt_exponent() const { return finest.value + tile_exponent; }
  [[nodiscard]] std::uint32_t tile_texels() const { return std::uint32_t{1} << tile_exponent; }
  // The texels of `level` that have any part in the data; every level sits on the padded square's grid.
  [[nodiscard]] TexelRect data_rect(Level level) const { return coarser(data, finest.value - level.value); }
  // The tiles of `level` that have any part in the data, as a rectangle counted in tiles.
  [[nodiscard]] TexelRect tile_rect(Level level) const { return coarser(data_rect(level), tile_exponent); }
  [[nodiscard]] std::size_t tile_payload_bytes() const { return payload_bytes(format_info(format), tile_texels(), tile_texels()); }
};

}  // namespace vt
