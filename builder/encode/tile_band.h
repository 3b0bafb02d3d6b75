// Collects finished rows of one level of one block into tiles and turns a full row of tiles into what the store keeps: constant tiles are
// found, tiles without any data are dropped, texels outside the data are filled from the nearest data texel, then block encoding and
// compression. One object per thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "store/codec.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::encode {

// Views of the buffers of whoever made it.
struct EncodedTile {
  TileId tile;
  bool is_empty = false;                      // no texel has data: nothing is to be kept
  std::span<const std::byte> constant_block;  // one texel or one 4x4 block, when all are the same; otherwise empty
  store::PayloadView payload;                 // otherwise
};

using TileSink = std::function<Result<void>(const EncodedTile&)>;

// Every texel (or block, or planes of a texel) has the same bytes as the first; `texels` holds at least one, of `texel_bytes` each.
[[nodiscard]] bool is_one_value(std::span<const std::byte> texels, std::size_t texel_bytes);

class TileBand {
 public:
  // `core` is the part of the level that the block owns, inside the data; tiles at its edges belong to no other block.
  TileBand(const LayerInfo& layer, const channels::ChannelCodec& codec, store::Compression compression, Level level, const TexelRect& core);

  // Rows come in order from core.y to core.bottom() - 1. Pointers are at column core.x.
  void add_row(std::int64_t y, const channels::RowNeighbourhood& rows);
  // The same when the source's bytes already are texels; `weights` says which of them are data (null: all).
  void add_texels(std::int64_t y, const std::byte* texels, const float* weights);

  // After the last row of a row of tiles (or of the core): gives its tiles, empty ones too, to `sink` one by one. Otherwise does nothing.
  // What the sink fails with is passed on.
  [[nodiscard]] Result<void> take_finished(const TileSink& sink);

 private:
  struct OpenTile {
    std::uint32_t column = 0;
    bool has_data = false;
    std::vector<std::byte> texels;
  };

  template <class WriteSegment>
  void add_segments(std::int64_t y, const WriteSegment& write_segment);
  void fill_outside(OpenTile& tile) const;
  [[nodiscard]] Result<EncodedTile> encode(const OpenTile& tile);

  TexelFormat format_;
  const channels::ChannelCodec& codec_;
  store::Compression compression_;
  Level level_;
  TexelRect core_;
  std::int64_t tile_texels_;
  int tile_exponent_;
  std::size_t texel_bytes_;
  std::int64_t tile_row_ = 0;  // of the open tiles
  std::int64_t next_y_;
  std::vector<OpenTile> open_;
  std::vector<std::byte> blocks_;      // of the tile being encoded
  std::vector<std::byte> compressed_;  // likewise
};

}  // namespace vt::encode
