// One source of a layer, ready to be read: which bands, what they mean, and where they lie on the layer's grid. A value; the raster, the
// codec and the warp are shared and immutable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "builder/resample/grid_warp.h"
#include "builder/source/raster_source.h"
#include "store/content_hash.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::resample {

// How a source on another grid becomes texels.
enum class Method : std::uint8_t {
  kBilinear,  // between the four nearest samples, in filter space
  kNearest,   // the sample that the texel's centre lies in, as it is
};
[[nodiscard]] std::string_view method_name(Method method);  // "bilinear", "nearest"
[[nodiscard]] std::optional<Method> method_from_name(std::string_view name);

// Coordinates are texels of the layer's finest level, counted from the corner of its data rectangle.
struct PlacedSource {
  std::shared_ptr<const source::RasterSource> raster;
  std::vector<int> bands;         // value bands, then the coverage band if the layout has one
  channels::SampleLayout layout;  // of those bands
  std::shared_ptr<const channels::ChannelCodec> codec;
  // The source's first sample, when both share one grid.
  bool is_aligned = false;
  std::int64_t offset_x = 0;
  std::int64_t offset_y = 0;
  std::shared_ptr<const GridWarp> warp;  // otherwise
  Method method = Method::kBilinear;     // likewise
  TexelRect covered;                     // texels that the source can touch
  Point2 moved;                          // texels by which it was moved onto the grid (nearest); for reports

  // No sample can be without data, so nothing below the source is ever seen.
  [[nodiscard]] bool is_opaque() const;
  // For aligned sources: the samples under `part`, which lies inside `covered`.
  [[nodiscard]] source::Window window_of(const TexelRect& part) const {
    return {part.x - offset_x, part.y - offset_y, part.width, part.height};
  }

  // Samples of `window` with `row_pitch_bytes` from row to row, as RasterSource::read; the window and what was read is added to `content`
  // when it is given.
  [[nodiscard]] Result<void> read(const source::Window& window, std::span<std::byte> out, std::size_t row_pitch_bytes,
                                  store::ContentHasher* content) const;
  // Adds what read() would add. Nothing is decoded.
  [[nodiscard]] Result<void> hash(const source::Window& window, store::ContentHasher& content) const;
};

// All that turns the samples under `part` into texels and is not the samples themselves: the layout, and how the source lies relative to
// `rect`. Neither the source's name nor its place in a list, so that what is added elsewhere changes nothing here.
void add_mark(const PlacedSource& source, const TexelRect& part, const TexelRect& rect, store::ContentHasher& content);

}  // namespace vt::resample
