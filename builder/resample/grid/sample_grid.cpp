#include "builder/resample/grid/sample_grid.h"

#include <algorithm>
#include <ranges>
#include <span>

#include "builder/resample/grid/buffers.h"

namespace vt::resample {
namespace {

std::vector<TexelRect> rects_of(const std::vector<SampleGrid::Part>& parts) {
  std::vector<TexelRect> rects;
  rects.reserve(parts.size());
  for (const SampleGrid::Part& part : parts) rects.push_back(part.rect);
  return rects;
}

}  // namespace

void SampleGrid::add(const PlacedSource& source, std::int64_t x, std::int64_t y) {
  const source::RasterInfo& info = source.raster->info();
  const TexelRect rect{x, y, info.width, info.height};
  members_.push_back({&source, rect});
  bounds_ = members_.size() == 1 ? rect : united(bounds_, rect);
}

void SampleGrid::make_index() {
  std::vector<TexelRect> rects;
  rects.reserve(members_.size());
  for (const Member& member : members_) rects.push_back(member.rect);
  index_ = RectIndex(rects);
}

void SampleGrid::find_parts(const TexelRect& window, std::vector<std::uint32_t>& found, std::vector<Part>& parts) const {
  parts.clear();
  index_.find(window, found);
  // From the top down, so that what hides a source is there before it.
  for (const std::uint32_t number : found | std::views::reverse) {
    const TexelRect part = intersect(window, members_[number].rect);
    const auto hides_it = [&](const Part& upper) { return upper.member->source->is_opaque() && intersect(part, upper.rect) == part; };
    if (std::ranges::none_of(parts, hides_it)) parts.push_back({&members_[number], part, false});
  }
  std::ranges::reverse(parts);
  for (std::size_t i = 1; i < parts.size(); ++i)
    parts[i].lies_over_another = std::any_of(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(i),
                                             [&](const Part& lower) { return !intersect(lower.rect, parts[i].rect).empty(); });
}

bool SampleGrid::hides(const TexelRect& window, std::vector<std::uint32_t>& found) const {
  index_.find(window, found);
  return std::ranges::any_of(found, [&](std::uint32_t number) {
    return members_[number].source->is_opaque() && intersect(window, members_[number].rect) == window;
  });
}

Result<void> SampleGrid::read(const TexelRect& window, bool derived, SampleWindow& out, store::ContentHasher* content) const {
  const channels::ChannelCodec& codec = *members_.front().source->codec;
  out.block.rect = window;
  out.block.planes = derived ? codec.planes() : codec.source_planes();
  refit(out.block.floats, static_cast<std::size_t>(window.width * window.height * out.block.planes));
  out.there.clear();
  std::vector<Part> parts;
  find_parts(window, out.found, parts);
  const std::vector<TexelRect> rects = rects_of(parts);
  const bool is_full = covers(rects, window);
  if (!is_full) {
    out.there.assign(static_cast<std::size_t>(window.width * window.height), 0);
    for (const TexelRect& rect : rects)
      for (std::int64_t row = rect.y; row < rect.bottom(); ++row)
        std::fill_n(out.there.begin() + (row - window.y) * window.width + (rect.x - window.x), rect.width, std::uint8_t{1});
  }
  if (!is_full || parts.size() > 1)
    for (std::int64_t row = window.y; row < window.bottom(); ++row)
      fill_with_nothing(codec, derived, window.width, out.block.row_at(window.x, row));
  out.is_opaque = is_full && parts.size() == 1;
  for (const Part& part : parts) {
    if (content != nullptr) add_mark(*part.member->source, part.rect, window, *content);
    VT_CHECK(read_part(part, derived, out, content));
  }
  return {};
}

Result<void> SampleGrid::read_part(const Part& part, bool derived, SampleWindow& out, store::ContentHasher* content) {
  const TexelRect& rect = part.rect;
  const PlacedSource& source = *part.member->source;
  const channels::ChannelCodec& codec = *source.codec;
  const auto pitch = static_cast<std::size_t>(rect.width) * source.layout.texel_bytes();
  refit(out.samples, static_cast<std::size_t>(rect.height) * pitch);
  VT_CHECK(source.read(part.window(), out.samples, pitch, content));
  const int planes = out.block.planes;
  if (part.lies_over_another) refit(out.upper, static_cast<std::size_t>(rect.width * planes));
  for (std::int64_t row = 0; row < rect.height; ++row) {
    const channels::PlaneRow target = out.block.row_at(rect.x, rect.y + row);
    channels::PlaneRow upper = target;
    for (int p = 0; part.lies_over_another && p < planes; ++p) upper[static_cast<std::size_t>(p)] = out.upper.data() + p * rect.width;
    const bool opaque = codec.decode_row(out.samples.data() + static_cast<std::size_t>(row) * pitch, rect.width, upper);
    out.is_opaque = out.is_opaque && opaque;
    if (derived) codec.derive_row(rect.width, upper);
    if (part.lies_over_another)
      composite_row(upper, codec.rules().first(static_cast<std::size_t>(planes)), codec.weight_plane(), rect.width, target);
  }
  return {};
}

Result<void> SampleGrid::hash(const TexelRect& window, SampleWindow& buffers, store::ContentHasher& content) const {
  std::vector<Part> parts;
  find_parts(window, buffers.found, parts);
  for (const Part& part : parts) {
    add_mark(*part.member->source, part.rect, window, content);
    VT_CHECK(part.member->source->hash(part.window(), content));
  }
  return {};
}

}  // namespace vt::resample
