#include "builder/resample/base_sampler.h"

#include <algorithm>
#include <cassert>
#include <ranges>
#include <span>
#include <utility>

#include "builder/resample/buffers.h"

namespace vt::resample {

BaseSampler::BaseSampler(std::vector<PlacedSource> sources, std::int64_t width, std::int64_t height)
    : sources_(std::move(sources)), width_(width) {
  assert(!sources_.empty());
  std::vector<TexelRect> rects;
  rects.reserve(sources_.size());
  for (const PlacedSource& source : sources_) rects.push_back(source.covered);
  index_ = RectIndex(rects);
  const PlacedSource& first = sources_.front();
  passes_texels_ =
      sources_.size() == 1 && first.is_aligned && first.codec->samples_are_texels() && first.covered == TexelRect{0, 0, width, height};
}

std::uint64_t BaseSampler::most_squares_touched(std::int64_t edge, std::int64_t apron) const {
  const auto squares = [&](std::int64_t texels) { return static_cast<std::uint64_t>((texels + 2 * apron + edge - 2) / edge + 1); };
  std::uint64_t sum = 0;
  for (const PlacedSource& source : sources_)
    if (!source.covered.empty()) sum += squares(source.covered.width) * squares(source.covered.height);
  return sum;
}

// Sources under opaque ones are left out: they are neither read nor do they count as content.
void BaseSampler::find_parts(const TexelRect& rect, BaseChunk& chunk) const {
  std::vector<Part>& parts = chunk.parts_;
  parts.clear();
  index_.find(rect, chunk.found_);
  // From the top down, so that what hides a source is there before it.
  for (const std::uint32_t number : chunk.found_ | std::views::reverse) {
    const TexelRect part = intersect(rect, sources_[number].covered);
    const auto hides_it = [&](const Part& upper) { return upper.source->is_opaque() && intersect(part, upper.rect) == part; };
    if (std::ranges::none_of(parts, hides_it)) parts.push_back({&sources_[number], part, false});
  }
  std::ranges::reverse(parts);
  for (std::size_t i = 1; i < parts.size(); ++i)
    parts[i].lies_over_another = std::any_of(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(i),
                                             [&](const Part& lower) { return !intersect(lower.rect, parts[i].rect).empty(); });
}

// Whether the rectangle is full of samples of one layout, none of which has to be mixed with another.
bool BaseSampler::can_assemble(const TexelRect& rect, const std::vector<Part>& parts) {
  if (parts.empty()) return false;
  const PlacedSource& first = *parts.front().source;
  const auto fits = [&](const Part& part) {
    return part.source->is_aligned && part.source->layout == first.layout && (!part.lies_over_another || part.source->is_opaque());
  };
  if (!std::ranges::all_of(parts, fits)) return false;
  std::vector<TexelRect> rects;
  for (const Part& part : parts) rects.push_back(part.rect);
  return covers(rects, rect);
}

Result<void> BaseSampler::load(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher* content) const {
  find_parts(rect, chunk);
  chunk.block_.rect = rect;
  chunk.has_samples_ = can_assemble(rect, chunk.parts_);
  chunk.has_texels_ = false;
  return chunk.has_samples_ ? assemble(chunk, content) : composite(chunk, content);
}

Result<void> BaseSampler::assemble(BaseChunk& chunk, store::ContentHasher* content) const {
  const TexelRect& rect = chunk.rect();
  const PlacedSource& first = *chunk.parts_.front().source;
  chunk.codec_ = first.codec.get();
  chunk.texel_bytes_ = first.layout.texel_bytes();
  const std::size_t pitch = static_cast<std::size_t>(rect.width) * chunk.texel_bytes_;
  refit(chunk.samples_, static_cast<std::size_t>(rect.height) * pitch);
  // Texels that are not always opaque cannot be copied one by one: what a texel without data looks like depends on its neighbours, and
  // those may come from another source.
  const auto is_opaque = [](const Part& part) { return part.source->is_opaque(); };
  chunk.has_texels_ = passes_texels_ || (first.codec->samples_are_texels() && std::ranges::all_of(chunk.parts_, is_opaque));
  for (const Part& part : chunk.parts_) {
    if (content != nullptr) add_mark(*part.source, part.rect, rect, *content);
    const std::size_t at =
        static_cast<std::size_t>(part.rect.y - rect.y) * pitch + static_cast<std::size_t>(part.rect.x - rect.x) * chunk.texel_bytes_;
    VT_CHECK(part.source->read(part.source->window_of(part.rect), std::span(chunk.samples_).subspan(at), pitch, content));
  }
  return {};
}

Result<void> BaseSampler::composite(BaseChunk& chunk, store::ContentHasher* content) const {
  const TexelRect& rect = chunk.rect();
  chunk.block_.planes = codec().source_planes();
  refit(chunk.block_.floats, static_cast<std::size_t>(rect.width * rect.height * chunk.block_.planes));
  std::ranges::fill(chunk.block_.floats, 0.0F);
  for (const Part& part : chunk.parts_) {
    if (content != nullptr) add_mark(*part.source, part.rect, rect, *content);
    VT_CHECK(part.source->is_aligned ? composite_aligned(part, chunk, content)
                                     : composite_warped(*part.source, part.rect, chunk.warp_, chunk.block_, content));
  }
  return {};
}

Result<void> BaseSampler::composite_aligned(const Part& part, BaseChunk& chunk, store::ContentHasher* content) {
  const TexelRect& rect = part.rect;
  const auto pitch = static_cast<std::size_t>(rect.width) * part.source->layout.texel_bytes();
  refit(chunk.samples_, static_cast<std::size_t>(rect.height) * pitch);
  VT_CHECK(part.source->read(part.source->window_of(rect), chunk.samples_, pitch, content));
  const int planes = chunk.block_.planes;
  refit(chunk.decoded_, static_cast<std::size_t>(rect.width * planes));
  for (std::int64_t row = 0; row < rect.height; ++row) {
    const std::byte* samples = chunk.samples_.data() + static_cast<std::size_t>(row) * pitch;
    const channels::PlaneRow lower = chunk.block_.row_at(rect.x, rect.y + row);
    if (!part.lies_over_another) {
      part.source->codec->decode_row(samples, rect.width, lower);
      continue;
    }
    channels::PlaneRow upper{};
    for (int p = 0; p < planes; ++p) upper[static_cast<std::size_t>(p)] = chunk.decoded_.data() + p * rect.width;
    part.source->codec->decode_row(samples, rect.width, upper);
    composite_row(upper, planes, rect.width, lower);
  }
  return {};
}

Result<void> BaseSampler::hash(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher& content) const {
  find_parts(rect, chunk);
  for (const Part& part : chunk.parts_) {
    add_mark(*part.source, part.rect, rect, content);
    VT_CHECK(part.source->is_aligned ? part.source->hash(part.source->window_of(part.rect), content)
                                     : hash_warped(*part.source, part.rect, chunk.warp_, content));
  }
  return {};
}

void BaseSampler::release_rows_before(std::int64_t row) const {
  std::int64_t released = released_.load(std::memory_order_relaxed);
  while (released < row && !released_.compare_exchange_weak(released, row, std::memory_order_relaxed)) {
  }
  if (released >= row) return;
  // Sources that end above the rows now released have had their hint.
  std::vector<std::uint32_t> found;
  index_.find({0, released, width_, row - released}, found);
  for (const std::uint32_t number : found) {
    const PlacedSource& source = sources_[number];
    if (source.is_aligned) source.raster->release_rows_before(std::min(row - source.offset_y, source.raster->info().height));
  }
}

bool BaseChunk::decode_row(std::int64_t row, const channels::PlaneRow& out) const {
  const std::int64_t width = rect().width;
  if (has_samples_) return codec_->decode_row(samples_.data() + static_cast<std::size_t>(row * width) * texel_bytes_, width, out);
  const int planes = block_.planes;
  for (int p = 0; p < planes; ++p) std::copy_n(block_.floats.data() + (row * planes + p) * width, width, out[static_cast<std::size_t>(p)]);
  const float* weight = out[static_cast<std::size_t>(planes - 1)];
  return std::all_of(weight, weight + width, [](float w) { return w == 1.0F; });
}

const std::byte* BaseChunk::texel_row(std::int64_t row) const {
  return has_texels_ ? samples_.data() + static_cast<std::size_t>(row * rect().width) * texel_bytes_ : nullptr;
}

}  // namespace vt::resample
