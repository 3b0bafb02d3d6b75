// Puts an opened source into a layer: how its samples enter filter space, and where they lie on the layer's grid.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "builder/channels/channel_codec.h"
#include "builder/pipeline/choose_samples.h"
#include "builder/pipeline/layer_grid.h"
#include "builder/pipeline/open_sources.h"
#include "builder/resample/placed_source.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::pipeline {

// The codecs of one layer. Sources of one sample layout share one: some hold tables, and a mosaic has thousands of sources. For one thread.
class CodecShelf {
 public:
  // `settings` of the layer, the same in every call. Errors as channels::make_codec.
  [[nodiscard]] Result<std::shared_ptr<const channels::ChannelCodec>> codec_for(const channels::ChannelSettings& settings,
                                                                                const channels::SampleLayout& layout);

 private:
  std::vector<std::pair<channels::SampleLayout, std::shared_ptr<const channels::ChannelCodec>>> codecs_;
};

// All but the codec, which the caller adds. `bounds` are the source's in the layer's CRS.
[[nodiscard]] Result<resample::PlacedSource> place_source(const ChosenSamples& samples, resample::Method resampling, const LayerInfo& layer,
                                                          const geo::Crs& crs, const OpenSource& source, const Bounds& bounds);

}  // namespace vt::pipeline
