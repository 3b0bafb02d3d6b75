// Puts an opened source into a layer: how its samples enter filter space, and where they lie on the layer's
// grid.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pipeline/sources/choose_samples.h"
#include "builder/pipeline/sources/layer_grid.h"
#include "builder/pipeline/sources/open_sources.h"
#include "builder/resample/grid/placed_source.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::pipeline {

// The codecs of one layer. Sources of one sample layout share one: some hold tables, and a mosaic has
// thousands of sources. For one thread.
class CodecShelf {
 public:
  // `settings` of the layer, the same in every call. Errors as channels::make_codec.
  [[nodiscard]] Result<std::shared_ptr<const channels::ChannelCodec>> codec_for(const channels::ChannelSettings& settings,
                                                                                const channels::SampleLayout& layout);

 private:
  std::vector<std::pair<channels::SampleLayout, std::shared_ptr<const channels::ChannelCodec>>> codecs_;
};

// Where one source lies in a layer.
struct SourcePlaces {
  // At least one; several where longitude brings the source into the layer more than once. The first is empty
  // when the source lies outside.
  std::vector<resample::PlacedSource> placed;
  std::vector<int> turns;        // of each, round the globe to the east
  std::int64_t comes_again = 0;  // columns after which the source comes again, when it is read as one that goes round and round; else 0

  [[nodiscard]] bool is_empty() const { return placed.front().covered.empty(); }
};

// The layer that sources are put into. Both references outlive it.
struct LayerGround {
  LayerGround(const LayerInfo& layer_info, const geo::Crs& layer_crs);
  const LayerInfo& layer;
  const geo::Crs& crs;
  Bounds bounds;          // in its CRS
  Bounds longitudes_deg;  // that it covers, and latitudes; longitudes do not jump at the antimeridian
};

// All but the codecs, which the caller adds. `bounds` are the source's in the layer's CRS.
[[nodiscard]] SourcePlaces place_source(const ChosenSamples& samples, resample::Method resampling, const LayerGround& ground,
                                        const OpenSource& source, const Bounds& bounds);

// Whether any place of `area`, in the CRS of a layer, lies in the source: for sources that reach where that
// CRS has no answer.
[[nodiscard]] bool reaches_into(const Bounds& area, const geo::Crs& crs, const OpenSource& source);

}  // namespace vt::pipeline
