// The finest level of a layer, by rectangles: every source is brought onto the layer's grid and into its
// filter space, in the order given, later sources over earlier ones.
//
//   sources of one grid  ->  SampleGrid: one raster, sample over sample  ->  as it is, where the grid is the layer's
//                                                                        ->  warped_reader.h: resampled, where it is another
//   what comes of each grid  ->  composited texel by texel, in all planes of the codec (or areas of classes)  ->  BaseChunk
//
// Where one grid ends inside a texel, the texel is made of all that are seen in it: each of kPlaces places of
// the texel belongs to the last grid that has a source there. A texel whose centre lies in no source has no
// data. What a rectangle costs depends on the sources under it, not on how many there are. Threads: a
// BaseSampler is immutable and shared; a BaseChunk belongs to one thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/channels/codec/class_areas.h"
#include "builder/resample/grid/placed_source.h"
#include "builder/resample/grid/rect_index.h"
#include "builder/resample/grid/sample_grid.h"
#include "builder/resample/rows/texel_block.h"
#include "builder/resample/warped_reader.h"
#include "store/io/content_hash.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::resample {

class BaseChunk;

// Rectangles are in texels from the data rectangle's corner and lie inside the data rectangle.
class BaseSampler {
 public:
  // `sources` is not empty; all codecs are of one channel and format. `width` and `height` are those of the
  // data rectangle.
  BaseSampler(std::vector<PlacedSource> sources, std::int64_t width, std::int64_t height);

  [[nodiscard]] const channels::ChannelCodec& codec() const { return *sources_.front().codec; }
  // Every texel of the finest level is a source's own bytes. When false, that may still hold for a chunk:
  // BaseChunk::texel_row tells.
  [[nodiscard]] bool passes_texels() const { return passes_texels_; }
  // The layer is of classes, and texels may lie over many samples: see BaseChunk::class_areas.
  [[nodiscard]] bool counts_areas() const { return counts_areas_; }

  // Whether any source can give data in `rect`. Cheap: nothing is read. False is certain, true is not.
  [[nodiscard]] bool touches(const TexelRect& rect) const { return index_.touches(rect); }

  // At most so many squares of `edge` texels, on a grid of such squares, have a source within `apron` texels.
  [[nodiscard]] std::uint64_t most_squares_touched(std::int64_t edge, std::int64_t apron) const;

  // Reads what `rect` needs. Adds to `content`, when it is given, all that decides the result: for each
  // source that is seen in `rect`, in order, how it is read and what was read. Equal contents of equal
  // rectangles mean equal texels.
  [[nodiscard]] Result<void> load(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher* content = nullptr) const;
  // Adds to `content` exactly what load() would add. Nothing is decoded; `chunk` lends its buffers.
  [[nodiscard]] Result<void> hash(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher& content) const;

  // A hint that no row above `row` will be asked for again. Rows may still be asked for; then they are read
  // again.
  void release_rows_before(std::int64_t row) const;

 private:
  // Sources of one grid, at their place in the order of all.
  struct Group {
    GridSources sources;
    std::vector<TexelRect> covered;  // of each source the texels that it can touch
    RectIndex index;                 // of these
  };
  // What of a group is seen in a rectangle.
  struct GroupPart {
    const Group* group;
    TexelRect rect;
  };

  void add_to_group(const PlacedSource& source);
  [[nodiscard]] std::vector<GroupPart> find_groups(const TexelRect& rect, std::vector<std::uint32_t>& found) const;
  [[nodiscard]] static bool can_assemble(const TexelRect& rect, const std::vector<SampleGrid::Part>& parts);
  [[nodiscard]] Result<void> assemble(BaseChunk& chunk, store::ContentHasher* content) const;
  [[nodiscard]] Result<void> composite(const std::vector<GroupPart>& groups, BaseChunk& chunk, store::ContentHasher* content) const;
  // One of several groups.
  [[nodiscard]] Result<void> read_group(const GroupPart& part, BaseChunk& chunk, TexelBlock& out, store::ContentHasher* content) const;

  friend class BaseChunk;
  std::vector<PlacedSource> sources_;
  std::vector<Group> groups_;
  RectIndex index_;  // of the sources' covered rectangles
  std::int64_t width_;
  bool passes_texels_ = false;
  bool counts_areas_ = false;
  // Rows above have been released: hints go only to sources that have not had them.
  mutable std::atomic<std::int64_t> released_{0};
};

// Some rows of the finest level. Reused from call to call, so that its buffers are allocated once.
class BaseChunk {
 public:
  [[nodiscard]] const TexelRect& rect() const { return rect_; }
  // Whether the chunk's texels are given by class_areas() instead of decode_row().
  [[nodiscard]] bool has_class_areas() const { return !has_samples_ && texels_.has_areas; }
  // The classes in all texels of rect().
  [[nodiscard]] const channels::ClassAreaBlock& class_areas() const { return texels_.areas; }
  // The same of a chunk whose texels are of one class each: from now on they are given so.
  const channels::ClassAreaBlock& to_class_areas();
  // All planes of row `row` (0 = the first of the chunk) into `out`; returns whether all weights are exactly
  // 1.
  bool decode_row(std::int64_t row, const channels::PlaneRow& out) const;
  // The row's texels, when the bytes of the sources are passed on as they are; otherwise null.
  [[nodiscard]] const std::byte* texel_row(std::int64_t row) const;

 private:
  friend class BaseSampler;

  TexelRect rect_;
  const channels::ChannelCodec* codec_ = nullptr;  // of samples_, where there are some
  bool has_samples_ = false;                       // samples_ is the whole rectangle in one layout; otherwise texels_ holds its planes
  bool has_texels_ = false;                        // and the samples are texels
  std::size_t texel_bytes_ = 0;
  std::vector<std::byte> samples_;
  TexelBlock texels_;
  TexelBlock upper_;  // one group of several
  WarpBuffers warp_;
  std::vector<SampleGrid::Part> parts_;  // of the rectangle, in order
  std::vector<std::uint32_t> found_;
};

}  // namespace vt::resample
