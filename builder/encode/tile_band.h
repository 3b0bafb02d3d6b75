// Collects finished rows of one part of one level of one block into tiles and turns a full row of tiles into
// what the store keeps: constant tiles are found, tiles without any data are dropped, texels outside the data
// are filled from the nearest data texel, then block encoding and compression. What is stored is read back in
// some rows and compared with what it was made from. One object per thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/encode/quality.h"
#include "builder/encode/reference_rows.h"
#include "store/codec/codec.h"
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

// Every texel (or block, or planes of a texel) has the same bytes as the first; `texels` holds at least one,
// of `texel_bytes` each.
[[nodiscard]] bool is_one_value(std::span<const std::byte> texels, std::size_t texel_bytes);

class TileBand {
 public:
  // `layer` is the part's. `core` is the part of the level that the block owns, inside the data; tiles at its
  // edges belong to no other block. `reference` outlives the band and is given every row before the band is,
  // maybe one row earlier; null: nothing is measured.
  TileBand(const LayerInfo& layer, const channels::ChannelCodec& codec, std::size_t part, store::Compression compression, Quality quality,
           Level level, const TexelRect& core, const ReferenceRows* reference);

  [[nodiscard]] bool is_empty() const { return core_.empty(); }
  [[nodiscard]] Level level() const { return level_; }

  // Rows come in order from core.y to core.bottom() - 1. Pointers are at column core.x.
  // Errors as ChannelCodec::encode_row.
  [[nodiscard]] Result<void> add_row(std::int64_t y, const channels::RowNeighbourhood& rows);
  // The same when the source's bytes already are texels. `planes` are what they decode to; `opaque`: all
  // their weights are 1.
  void add_texels(std::int64_t y, const std::byte* texels, const channels::ConstPlaneRow& planes, bool opaque);

  // After the last row of a row of tiles (or of the core): gives its tiles, empty ones too, to `sink` one by
  // one. Otherwise does nothing. What the sink fails with is passed on.
  [[nodiscard]] Result<void> take_finished(const TileSink& sink);

  // The errors of the tiles given so far: what is stored against the planes, one sum for each of the codec's
  // measures.
  [[nodiscard]] std::span<const channels::ErrorSum> errors() const { return errors_; }

 private:
  struct OpenTile {
    std::uint32_t column = 0;
    bool has_data = false;
    std::vector<std::byte> texels;
  };

  template <class WriteSegment>
  void add_segments(std::int64_t y, const WriteSegment& write_segment);
  void fill_outside(OpenTile& tile) const;
  [[nodiscard]] Result<EncodedTile> encode(OpenTile& tile);
  void measure(const OpenTile& tile, std::span<const std::byte> stored, bool is_constant);

  TexelFormat format_;
  const channels::ChannelCodec& codec_;
  std::size_t part_;
  store::Compression compression_;
  Quality quality_;
  Level level_;
  TexelRect core_;
  const ReferenceRows* reference_;
  std::int64_t tile_texels_;
  int tile_exponent_;
  std::size_t texel_bytes_;
  std::int64_t tile_row_ = 0;  // of the open tiles
  std::int64_t next_y_;
  std::vector<OpenTile> open_;
  std::vector<std::byte> blocks_;      // of the tile being encoded
  std::vector<std::byte> compressed_;  // likewise
  std::vector<float> decoded_;         // a row of blocks of the tile being measured
  std::vector<channels::ErrorSum> errors_;
};

}  // namespace vt::encode
