// The finest level of a layer, by rectangles: every source is brought onto the layer's grid and into its filter space, in the order given,
// later sources over earlier ones. A source whose own grid is the layer's grid is passed through sample by sample; any other is resampled
// (bilinear). Threads: a BaseSampler is immutable and shared; a BaseChunk belongs to one thread.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "builder/resample/grid_warp.h"
#include "builder/source/raster_source.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::resample {

// One source of a layer, ready to be read.
struct PlacedSource {
  std::shared_ptr<const source::RasterSource> raster;
  std::vector<int> bands;  // value bands, then the coverage band if the codec's layout has one
  std::shared_ptr<const channels::ChannelCodec> codec;
  std::size_t texel_bytes = 0;  // of one texel of the chosen bands
  // The source's first sample in texels of the layer, from the data rectangle's corner, when both share one grid.
  bool is_aligned = false;
  std::int64_t offset_x = 0;
  std::int64_t offset_y = 0;
  std::shared_ptr<const GridWarp> warp;  // otherwise
  TexelRect covered;                     // texels of the layer (from the data rectangle's corner) that the source can touch
};

class BaseChunk;

class BaseSampler {
 public:
  explicit BaseSampler(std::vector<PlacedSource> sources);

  [[nodiscard]] const channels::ChannelCodec& codec() const { return *sources_.front().codec; }
  // The source's own bytes become the finest level's texels wherever possible.
  [[nodiscard]] bool passes_texels() const { return passes_texels_; }

  // Reads what `rect` needs (texels from the data rectangle's corner). `rect` lies inside the data rectangle.
  [[nodiscard]] Result<void> load(const TexelRect& rect, BaseChunk& chunk) const;

 private:
  [[nodiscard]] Result<void> load_resampled(const PlacedSource& source, const TexelRect& part, BaseChunk& chunk) const;
  [[nodiscard]] Result<void> load_aligned(const PlacedSource& source, const TexelRect& part, BaseChunk& chunk) const;

  std::vector<PlacedSource> sources_;
  bool passes_texels_ = false;
};

// Some rows of the finest level. Reused from call to call, so that its buffers are allocated once.
class BaseChunk {
 public:
  [[nodiscard]] const TexelRect& rect() const { return rect_; }
  // Planes of row `row` (0 = the first of the chunk) into `out`; returns whether all weights are exactly 1.
  bool decode_row(std::int64_t row, const channels::PlaneRow& out) const;
  // The row's texels, when the bytes of the source are passed on as they are; otherwise null.
  [[nodiscard]] const std::byte* texel_row(std::int64_t row) const;

 private:
  friend class BaseSampler;
  [[nodiscard]] float* plane_row(std::int64_t row, int plane) { return planes_.data() + (row * plane_count_ + plane) * rect_.width; }

  TexelRect rect_;
  const channels::ChannelCodec* codec_ = nullptr;
  int plane_count_ = 0;
  bool has_samples_ = false;  // samples_ is the whole rectangle of one aligned source; otherwise planes_ is
  bool has_texels_ = false;
  std::size_t texel_bytes_ = 0;
  std::vector<std::byte> samples_;
  std::vector<float> planes_;
  std::vector<float> source_planes_;  // a window of one source, decoded
  std::vector<Point2> positions_;
  std::vector<float> resampled_;  // one row of one source on the layer's grid
};

}  // namespace vt::resample
