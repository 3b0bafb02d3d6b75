#include "builder/pipeline/plan/wrapped_chunk.h"

#include <algorithm>
#include <span>

#include "builder/pipeline/plan/tiers.h"

namespace vt::pipeline {

Result<void> WrappedChunk::load(const LayerPlan& plan, const TexelRect& rect, store::ContentHasher* content) {
  rect_ = rect;
  parts_ = pyramid::wrapped_parts(rect, plan.info.data);
  chunks_.resize(std::max(chunks_.size(), parts_.size()));
  for (std::size_t i = 0; i < parts_.size(); ++i)
    VT_CHECK(plan.sampler->load(from_corner_of(plan.info.data, parts_[i].rect), chunks_[i], content));
  const std::span<resample::BaseChunk> chunks(chunks_.data(), parts_.size());
  areas_.clear();
  if (std::ranges::any_of(chunks, &resample::BaseChunk::has_class_areas))
    for (resample::BaseChunk& chunk : chunks) areas_.push_back(&chunk.to_class_areas());
  return {};
}

Result<void> WrappedChunk::hash(const LayerPlan& plan, const TexelRect& rect, store::ContentHasher& content) {
  chunks_.resize(std::max<std::size_t>(chunks_.size(), 1));
  for (const pyramid::WrappedPart& part : pyramid::wrapped_parts(rect, plan.info.data))
    VT_CHECK(plan.sampler->hash(from_corner_of(plan.info.data, part.rect), chunks_.front(), content));
  return {};
}

bool WrappedChunk::decode_row(const channels::ChannelCodec& codec, std::int64_t y, const channels::PlaneRow& out) const {
  bool opaque = true;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    channels::PlaneRow planes = out;
    for (std::size_t p = 0; p < static_cast<std::size_t>(codec.planes()); ++p) planes[p] += parts_[i].offset;
    opaque = chunks_[i].decode_row(y - rect_.y, planes) && opaque;
  }
  return opaque;
}

const std::byte* WrappedChunk::texel_row(const channels::ChannelCodec& codec, std::int64_t y, std::int64_t x) const {
  // The part whose columns are counted as `x` is.
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const TexelRect& part = parts_[i].rect;
    if (rect_.x + parts_[i].offset != part.x || x < part.x || x >= part.right()) continue;
    const std::byte* const texels = chunks_[i].texel_row(y - rect_.y);
    const auto texel_bytes = static_cast<std::int64_t>(format_info(codec.parts().front().texel_format).block_bytes);
    return texels != nullptr ? texels + (x - part.x) * texel_bytes : nullptr;
  }
  return nullptr;
}

}  // namespace vt::pipeline
