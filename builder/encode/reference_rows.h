// Planes of the rows of one level of one block that are measured, kept until what is stored of them can be
// compared with them: one copy for the bands of all parts. One object per thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "store/layer.h"

namespace vt::encode {

// Errors are measured in whole rows of blocks, four texel rows each: in all of them in levels of up to so
// many texels, in one of sixteen in larger ones.
inline constexpr std::int64_t kDenselyMeasuredTexels = std::int64_t{1} << 20;
inline constexpr std::int64_t kMeasuredRowOfBlocks = 16;

// Rows of a tile's height that are kept of a level.
[[nodiscard]] std::int64_t measured_rows_of_tile(const LayerInfo& layer, Level level);

class ReferenceRows {
 public:
  // `core` as of the TileBands that read it. Keeps rows of `planes` planes, of one row of tiles at a time;
  // nothing when `core` is empty.
  ReferenceRows(const LayerInfo& layer, int planes, Level level, const TexelRect& core);

  // Row `y` of the core, in order, before any band takes it; pointers are at column core.x. A row that comes
  // one row early for some bands replaces the one a row of tiles before, which none reads any more.
  void keep(std::int64_t y, const channels::ConstPlaneRow& rows);

  // Rows of a block of four are measured together.
  [[nodiscard]] bool is_measured(std::int64_t y) const;
  // A measured row from column core.x on; valid until keep() comes to the row of tiles below.
  [[nodiscard]] channels::ConstPlaneRow row(std::int64_t y) const;

 private:
  [[nodiscard]] std::size_t offset_of(std::int64_t y, int plane) const;

  int planes_;
  TexelRect core_;
  int tile_exponent_;
  bool is_dense_;
  std::vector<float> floats_;
};

}  // namespace vt::encode
