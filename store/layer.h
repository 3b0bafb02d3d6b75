// A layer: one virtual texture in a store. A store holds many layers over one area; they may differ in
// everything but that area.
#pragma once

#include <array>
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

// The rectangle of the dataset in the units of its coordinate reference system; (u, v) run 0..1 over it from
// the south-west corner.
struct Area {
  double west = 0.0;
  double south = 0.0;
  double east = 1.0;
  double north = 1.0;
  auto operator<=>(const Area&) const = default;
};

// The layer's finest grid on the ground. Coordinates of texel edges are always origin + i * step, never a
// running sum.
struct GridPlacement {
  double origin_x = 0.0;  // outer north-west corner of the data rectangle, CRS units
  double origin_y = 0.0;
  double step_x = 1.0;  // CRS units per finest texel, to the east; > 0
  double step_y = 1.0;  // CRS units per finest texel, to the south; > 0 for a north-up grid
  auto operator<=>(const GridPlacement&) const = default;
};

// What the samples of one component of a texel are worth: value = offset + scale * sample, in the channel's
// unit. A sample is the integer code in unorm formats (0 to 255, 0 to 65535), the decoded value on the scale
// of 0 to 255 in bc1, bc3, bc4, bc5 and bc7, and the number itself in half, float, rgb9e5 and bc6h.
struct ComponentRange {
  double scale = 1.0;  // finite, not 0
  double offset = 0.0;
  auto operator<=>(const ComponentRange&) const = default;
};

// `channel` and `format` hold the numbers of the file, which this program need not know.
struct LayerInfo {
  LayerId id;        // given by the store
  std::string name;  // 1..63 bytes of UTF-8, unique in the store
  ChannelType channel = ChannelType::kColor;
  TexelFormat format = TexelFormat::kRgb8;
  Transfer transfer = Transfer::kLinear;
  LayerRole role = LayerRole::kTexture;
  LayerState state = LayerState::kBuilding;
  LayerId owner;         // of kCarry and of a part: the texture layer it belongs to and goes with, itself no part; else 0
  bool is_part = false;  // kTexture only: more of what `owner` says, such as the length beside a direction
  std::uint8_t tile_exponent = 8;
  Level finest;    // the padded square is 2^(finest + tile_exponent) texels wide at this level
  TexelRect data;  // finest-level texels that the source covers, inside the padded square
  GridPlacement grid;
  // What "no data" was called in the source, so that `extract` can give it back; NaN when the source had
  // none.
  double source_nodata = std::numeric_limits<double>::quiet_NaN();
  std::array<ComponentRange, 4> components;  // those past the format's channels mean nothing and are as they begin
  bool zero_is_nodata = false;               // of 8- and 16-bit codes: code 0 in component 0 means "no data"
  bool is_point_sampled = false;             // a coarse texel's value is that of one finest texel, see value_offset()
  std::string metadata_json;                 // for tools; the runtime does not read it

  // Kept by the store.
  std::uint64_t tiles = 0;  // entries present, constants included
  std::uint64_t constant_tiles = 0;
  std::uint64_t stored_bytes = 0;  // bytes of tile records that the index points to; shared records count once per tile

  [[nodiscard]] int vt_exponent() const { return finest.value + tile_exponent; }
  [[nodiscard]] std::uint32_t tile_texels() const { return std::uint32_t{1} << tile_exponent; }
  // Without it the layer's tiles cannot be read or written, only kept or removed; see unknown_format_text().
  [[nodiscard]] bool has_known_format() const { return is_known(format); }
  [[nodiscard]] bool holds_blobs() const { return format == TexelFormat::kBlob; }
  [[nodiscard]] bool has_owner() const { return role == LayerRole::kCarry || is_part; }
  // The texels of `level` that have any part in the data; every level sits on the padded square's grid.
  [[nodiscard]] TexelRect data_rect(Level level) const { return coarser(data, finest.value - level.value); }
  // The tiles of `level` that have any part in the data, as a rectangle counted in tiles.
  [[nodiscard]] TexelRect tile_rect(Level level) const { return coarser(data_rect(level), tile_exponent); }
  // Where in a texel of `level` its value lies, in texels from its north-western corner, along both axes: in
  // the middle, as means do; where coarse levels are picked from finer ones, in the middle of the finest
  // texel at that corner.
  [[nodiscard]] double value_offset(Level level) const {
    return is_point_sampled ? 0.5 / static_cast<double>(std::uint64_t{1} << (finest.value - level.value)) : 0.5;
  }
  // The decoded bytes of every tile; 0 in a layer of blobs, whose tiles have sizes of their own, and of an
  // unknown format.
  [[nodiscard]] std::size_t tile_payload_bytes() const { return payload_bytes(format_info(format), tile_texels(), tile_texels()); }
};

// A sentence for people about a layer whose format is not known.
[[nodiscard]] inline std::string unknown_format_text(const LayerInfo& layer) {
  return "layer " + layer.name + ": its texel format has number " + std::to_string(static_cast<unsigned>(layer.format)) +
         ", which this program does not know; a newer program wrote it, and a newer one reads it";
}

}  // namespace vt
