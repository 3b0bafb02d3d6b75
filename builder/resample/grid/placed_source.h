// One source of a layer, ready to be read: which bands, what they mean, and where they lie on the layer's
// grid. A value; the raster, the codec and the warp are shared and immutable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/resample/grid/grid_warp.h"
#include "builder/source/raster_source.h"
#include "store/io/content_hash.h"
#include "store/result.h"
#include "store/tile_id.h"

namespace vt::resample {

// How a source on another grid becomes texels where a texel has no more than one of its samples under it;
// where it has more, each of them counts by its area, see warped_reader.h.
enum class Method : std::uint8_t {
  kBilinear,  // between the four nearest samples, in filter space
  kNearest,   // the sample that the texel's centre lies in, as it is
};
[[nodiscard]] std::string_view method_name(Method method);  // "bilinear", "nearest"
[[nodiscard]] std::optional<Method> method_from_name(std::string_view name);

// A new number whenever samples of another grid would become other texels. It is part of what blocks were
// built from, and of what a layer says of such sources, so that no layer is half of old rules and half of new
// ones.
inline constexpr int kWarpRules = 2;

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

  // No sample can be without data, so nothing below them is ever seen.
  [[nodiscard]] bool is_opaque() const;

  // Samples of `window` with `row_pitch_bytes` from row to row, as RasterSource::read; the window and what
  // was read is added to `content` when it is given.
  [[nodiscard]] Result<void> read(const source::Window& window, std::span<std::byte> out, std::size_t row_pitch_bytes,
                                  store::ContentHasher* content) const;
  // Adds what read() would add. Nothing is decoded.
  [[nodiscard]] Result<void> hash(const source::Window& window, store::ContentHasher& content) const;
};

// All that turns samples into values and is not the samples themselves: the layout, and where the samples of
// `part` lie in `window`, both counted alike. Neither the source's name nor its place in a list, so that what
// is added elsewhere changes nothing here.
void add_mark(const PlacedSource& source, const TexelRect& part, const TexelRect& window, store::ContentHasher& content);
// All that turns the samples of another grid into the texels of `part` of a layer: the warp and its rules.
void add_warp_mark(const GridWarp& warp, Method method, const TexelRect& part, store::ContentHasher& content);

}  // namespace vt::resample
