#include "builder/resample/base_sampler.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <ranges>
#include <span>
#include <utility>

#include "builder/resample/grid/buffers.h"

namespace vt::resample {
namespace {

// `count` texels of a row, each all of its class.
void set_whole_texels(const channels::PlaneRow& planes, std::int64_t x, std::int64_t y, std::int64_t count, channels::ClassAreaBlock& out) {
  for (std::int64_t i = 0; i < count; ++i) {
    const channels::ClassArea all{planes[0][i], 1.0};
    if (planes[channels::kClassWeightPlane][i] > 0.0F) out.set(x + i, y, {&all, 1});
  }
}

}  // namespace

BaseSampler::BaseSampler(std::vector<PlacedSource> sources, std::int64_t width, std::int64_t height)
    : sources_(std::move(sources)), width_(width) {
  assert(!sources_.empty());
  std::vector<TexelRect> rects;
  rects.reserve(sources_.size());
  for (const PlacedSource& source : sources_) rects.push_back(source.covered);
  index_ = RectIndex(rects);
  for (const PlacedSource& source : sources_)
    if (!source.covered.empty()) add_to_group(source);
  for (Group& group : groups_) {
    group.sources.grid.make_index();
    group.index = RectIndex(group.covered);
    if (!group.sources.warp || !codec().class_counting()) continue;
    counts_areas_ = counts_areas_ || std::ranges::any_of(group.covered, [&](const TexelRect& covered) {
                      return group.sources.warp->most_samples_per_texel(covered) > kMostPicked;
                    });
  }
  for (Group& group : groups_) group.sources.counts_areas = counts_areas_;
  const PlacedSource& first = sources_.front();
  passes_texels_ =
      sources_.size() == 1 && first.is_aligned && first.codec->samples_are_texels() && first.covered == TexelRect{0, 0, width, height};
}

// A source joins the last group of its grid, unless another one that has come since lies over that group
// where the source lies.
void BaseSampler::add_to_group(const PlacedSource& source) {
  const source::RasterInfo& info = source.raster->info();
  for (auto group = groups_.rbegin(); group != groups_.rend(); ++group) {
    GridSources& sources = group->sources;
    std::optional<GridWarp::SampleOffset> offset;
    if (source.is_aligned && !sources.warp) offset = {source.offset_x, source.offset_y};
    if (!source.is_aligned && sources.warp && sources.method == source.method)
      offset = sources.warp->offset_of(*source.warp, info.width, info.height);
    if (offset) {
      sources.grid.add(source, offset->x, offset->y);
      group->covered.push_back(source.covered);
      return;
    }
    if (std::ranges::any_of(group->covered, [&](const TexelRect& rect) { return !intersect(rect, source.covered).empty(); })) break;
  }
  Group& group = groups_.emplace_back();
  if (source.is_aligned) {
    group.sources.grid.add(source, source.offset_x, source.offset_y);
  } else {
    group.sources.grid.add(source, 0, 0);
    group.sources.warp = source.warp;
    group.sources.method = source.method;
  }
  group.covered.push_back(source.covered);
}

std::uint64_t BaseSampler::most_squares_touched(std::int64_t edge, std::int64_t apron) const {
  const auto squares = [&](std::int64_t texels) { return static_cast<std::uint64_t>((texels + 2 * apron + edge - 2) / edge + 1); };
  std::uint64_t sum = 0;
  for (const PlacedSource& source : sources_)
    if (!source.covered.empty()) sum += squares(source.covered.width) * squares(source.covered.height);
  return sum;
}

// Those that lie wholly under an opaque source of the layer's grid are left out: they are neither read nor do
// they count as content.
std::vector<BaseSampler::GroupPart> BaseSampler::find_groups(const TexelRect& rect, std::vector<std::uint32_t>& found) const {
  std::vector<GroupPart> parts;
  for (std::size_t i = groups_.size(); i-- > 0;) {
    const Group& group = groups_[i];
    group.index.find(rect, found);
    if (found.empty()) continue;
    TexelRect part = rect;  // of the layer's grid all of it, with its gaps
    if (group.sources.warp) {
      part = intersect(rect, group.covered[found.front()]);
      for (const std::uint32_t number : found) part = united(part, intersect(rect, group.covered[number]));
    }
    const auto hides_it = [&](const GroupPart& upper) {
      return !upper.group->sources.warp && upper.group->sources.grid.hides(part, found);
    };
    if (std::ranges::none_of(parts, hides_it)) parts.push_back({&group, part});
  }
  std::ranges::reverse(parts);
  return parts;
}

// Whether the rectangle is full of samples of one layout, none of which has to be mixed with another.
bool BaseSampler::can_assemble(const TexelRect& rect, const std::vector<SampleGrid::Part>& parts) {
  if (parts.empty()) return false;
  const PlacedSource& first = *parts.front().member->source;
  const auto fits = [&](const SampleGrid::Part& part) {
    const PlacedSource& source = *part.member->source;
    return source.layout == first.layout && (!part.lies_over_another || source.is_opaque());
  };
  if (!std::ranges::all_of(parts, fits)) return false;
  std::vector<TexelRect> rects;
  for (const SampleGrid::Part& part : parts) rects.push_back(part.rect);
  return covers(rects, rect);
}

Result<void> BaseSampler::load(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher* content) const {
  chunk.rect_ = rect;
  chunk.codec_ = &codec();
  chunk.has_samples_ = false;
  chunk.has_texels_ = false;
  const std::vector<GroupPart> groups = find_groups(rect, chunk.found_);
  if (groups.size() == 1 && !groups.front().group->sources.warp) {
    groups.front().group->sources.grid.find_parts(rect, chunk.found_, chunk.parts_);
    chunk.has_samples_ = can_assemble(rect, chunk.parts_);
  }
  return chunk.has_samples_ ? assemble(chunk, content) : composite(groups, chunk, content);
}

Result<void> BaseSampler::assemble(BaseChunk& chunk, store::ContentHasher* content) const {
  const TexelRect& rect = chunk.rect();
  const PlacedSource& first = *chunk.parts_.front().member->source;
  chunk.codec_ = first.codec.get();
  chunk.texel_bytes_ = first.layout.texel_bytes();
  const std::size_t pitch = static_cast<std::size_t>(rect.width) * chunk.texel_bytes_;
  refit(chunk.samples_, static_cast<std::size_t>(rect.height) * pitch);
  // Texels that are not always opaque cannot be copied one by one: what a texel without data looks like
  // depends on its neighbours, and those may come from another source.
  const auto is_opaque = [](const SampleGrid::Part& part) { return part.member->source->is_opaque(); };
  chunk.has_texels_ = passes_texels_ || (first.codec->samples_are_texels() && std::ranges::all_of(chunk.parts_, is_opaque));
  for (const SampleGrid::Part& part : chunk.parts_) {
    if (content != nullptr) add_mark(*part.member->source, part.rect, rect, *content);
    const std::size_t at =
        static_cast<std::size_t>(part.rect.y - rect.y) * pitch + static_cast<std::size_t>(part.rect.x - rect.x) * chunk.texel_bytes_;
    VT_CHECK(part.member->source->read(part.window(), std::span(chunk.samples_).subspan(at), pitch, content));
  }
  return {};
}

Result<void> BaseSampler::composite(const std::vector<GroupPart>& groups, BaseChunk& chunk, store::ContentHasher* content) const {
  const auto is_warped = [](const GroupPart& part) { return part.group->sources.warp != nullptr; };
  const bool has_areas = counts_areas_ && std::ranges::any_of(groups, is_warped);
  if (groups.size() == 1 && !is_warped(groups.front())) {
    VT_CHECK(groups.front().group->sources.grid.read(chunk.rect(), true, chunk.warp_.window, content));
    chunk.texels_.has_areas = false;
    std::swap(chunk.texels_.block, chunk.warp_.window.block);
    return {};
  }
  const bool is_mosaic = groups.size() > 1;
  clear(chunk.texels_, chunk.rect(), codec(), has_areas, is_mosaic);
  if (groups.size() == 1) return read_warped(groups.front().group->sources, groups.front().rect, true, chunk.warp_, chunk.texels_, content);
  for (const GroupPart& part : groups) {
    clear(chunk.upper_, part.rect, codec(), has_areas, is_mosaic);
    VT_CHECK(read_group(part, chunk, chunk.upper_, content));
    lay_over(chunk.upper_, codec(), chunk.texels_);
  }
  if (is_mosaic) drop_without_centre(codec(), chunk.texels_);
  return {};
}

Result<void> BaseSampler::read_group(const GroupPart& part, BaseChunk& chunk, TexelBlock& out, store::ContentHasher* content) const {
  const GridSources& sources = part.group->sources;
  if (sources.warp) return read_warped(sources, part.rect, false, chunk.warp_, out, content);
  SampleWindow& window = chunk.warp_.window;
  VT_CHECK(sources.grid.read(part.rect, true, window, content));
  const auto texels = static_cast<std::size_t>(part.rect.width * part.rect.height);
  for (std::size_t i = 0; i < texels; ++i) {
    const bool is_there = window.there.empty() || window.there[i] != 0;
    out.places[i] = is_there ? kAllPlaces : 0;
    out.has_centre[i] = is_there ? 1 : 0;
  }
  if (!out.has_areas) {
    std::swap(out.block, window.block);
    return {};
  }
  for (std::int64_t y = part.rect.y; y < part.rect.bottom(); ++y)
    set_whole_texels(window.block.row_at(part.rect.x, y), part.rect.x, y, part.rect.width, out.areas);
  return {};
}

Result<void> BaseSampler::hash(const TexelRect& rect, BaseChunk& chunk, store::ContentHasher& content) const {
  const std::vector<GroupPart> groups = find_groups(rect, chunk.found_);
  for (const GroupPart& part : groups) {
    const GridSources& sources = part.group->sources;
    VT_CHECK(sources.warp ? hash_warped(sources, part.rect, groups.size() == 1, chunk.warp_, content)
                          : sources.grid.hash(part.rect, chunk.warp_.window, content));
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
  const std::int64_t width = rect_.width;
  if (has_samples_) {
    const bool opaque = codec_->decode_row(samples_.data() + static_cast<std::size_t>(row * width) * texel_bytes_, width, out);
    codec_->derive_row(width, out);
    return opaque;
  }
  const channels::ConstPlaneRow planes = texels_.block.row_at(rect_.x, rect_.y + row);
  for (std::size_t p = 0; p < static_cast<std::size_t>(texels_.block.planes); ++p) std::copy_n(planes[p], width, out[p]);
  const float* const weight = out[static_cast<std::size_t>(codec_->weight_plane())];
  return std::all_of(weight, weight + width, [](float w) { return w == 1.0F; });
}

const channels::ClassAreaBlock& BaseChunk::to_class_areas() {
  if (has_class_areas()) return texels_.areas;
  std::vector<float> row(static_cast<std::size_t>(codec_->planes() * rect_.width));
  channels::PlaneRow planes{};
  for (int p = 0; p < codec_->planes(); ++p) planes[static_cast<std::size_t>(p)] = row.data() + p * rect_.width;
  texels_.areas.reset(rect_);
  for (std::int64_t y = 0; y < rect_.height; ++y) {
    decode_row(y, planes);
    set_whole_texels(planes, rect_.x, rect_.y + y, rect_.width, texels_.areas);
  }
  has_samples_ = has_texels_ = false;
  texels_.has_areas = true;
  return texels_.areas;
}

const std::byte* BaseChunk::texel_row(std::int64_t row) const {
  return has_texels_ ? samples_.data() + static_cast<std::size_t>(row * rect_.width) * texel_bytes_ : nullptr;
}

}  // namespace vt::resample
