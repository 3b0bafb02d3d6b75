// Rows of the finest level of a layer, whose columns may count on past the edges of a closed layer's data
// rectangle: then they come in two parts or more. Reused from call to call, so that buffers are allocated
// once. One object per thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/channels/codec/class_areas.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pyramid/layer_shape.h"
#include "builder/resample/base_sampler.h"
#include "store/io/content_hash.h"
#include "store/result.h"

namespace vt::pipeline {

class WrappedChunk {
 public:
  // `rect` lies inside the data from north to south. Samples that are read are added to `content` when there
  // is one.
  [[nodiscard]] Result<void> load(const LayerPlan& plan, const TexelRect& rect, store::ContentHasher* content = nullptr);
  // Only what load() would add to `content`.
  [[nodiscard]] Result<void> hash(const LayerPlan& plan, const TexelRect& rect, store::ContentHasher& content);

  // For a layer whose texels may be of several classes: the texels of all rows instead of decode_row(), in
  // parts from west to east. Otherwise empty.
  [[nodiscard]] std::span<const channels::ClassAreaBlock* const> class_areas() const { return areas_; }
  // All planes of row `y` of the layer, from column rect.x on; returns whether all weights are exactly 1.
  bool decode_row(const channels::ChannelCodec& codec, std::int64_t y, const channels::PlaneRow& out) const;
  // The texels of row `y` from column `x` on, which lies inside the data, when the bytes of the sources are
  // passed on as they are; otherwise null.
  [[nodiscard]] const std::byte* texel_row(const channels::ChannelCodec& codec, std::int64_t y, std::int64_t x) const;

 private:
  TexelRect rect_;
  std::vector<pyramid::WrappedPart> parts_;
  std::vector<resample::BaseChunk> chunks_;  // one for each part, and perhaps more
  std::vector<const channels::ClassAreaBlock*> areas_;
};

}  // namespace vt::pipeline
