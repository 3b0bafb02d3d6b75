#include "builder/resample/base_sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace vt::resample {
namespace {

constexpr std::int64_t kMostWindowSamples = std::int64_t{1} << 20;  // of a source, decoded at once

// Premultiplied "over": where the upper one has full weight nothing of the lower one remains.
void composite_row(const channels::ConstPlaneRow& upper, int planes, std::int64_t count, const channels::PlaneRow& lower) {
  const float* weight = upper[static_cast<std::size_t>(planes - 1)];
  for (int p = 0; p < planes; ++p) {
    const float* from = upper[static_cast<std::size_t>(p)];
    float* to = lower[static_cast<std::size_t>(p)];
    for (std::int64_t i = 0; i < count; ++i) to[i] = weight[i] == 1.0F ? from[i] : from[i] + (1.0F - weight[i]) * to[i];
  }
}

}  // namespace

BaseSampler::BaseSampler(std::vector<PlacedSource> sources) : sources_(std::move(sources)) {
  assert(!sources_.empty());
  // With several sources only texels that are always opaque may be copied: elsewhere the neighbours' colours count, and those may come from
  // another source.
  passes_texels_ = sources_.size() == 1 && sources_[0].is_aligned && sources_[0].codec->samples_are_texels();
}

Result<void> BaseSampler::load(const TexelRect& rect, BaseChunk& chunk) const {
  chunk.rect_ = rect;
  chunk.codec_ = &codec();
  chunk.plane_count_ = codec().planes();
  chunk.has_samples_ = chunk.has_texels_ = false;

  if (sources_.size() == 1 && sources_[0].is_aligned && intersect(rect, sources_[0].covered) == rect) {
    const PlacedSource& only = sources_[0];
    chunk.texel_bytes_ = only.texel_bytes;
    const auto pitch = static_cast<std::size_t>(rect.width) * only.texel_bytes;
    chunk.samples_.resize(static_cast<std::size_t>(rect.height) * pitch);
    chunk.has_samples_ = true;
    chunk.has_texels_ = passes_texels_;
    return only.raster->read({rect.x - only.offset_x, rect.y - only.offset_y, rect.width, rect.height}, only.bands, chunk.samples_, pitch);
  }

  chunk.planes_.assign(static_cast<std::size_t>(rect.width * rect.height * chunk.plane_count_), 0.0F);
  for (const PlacedSource& source : sources_) {
    const TexelRect part = intersect(rect, source.covered);
    if (part.empty()) continue;
    VT_CHECK(source.is_aligned ? load_aligned(source, part, chunk) : load_resampled(source, part, chunk));
  }
  return {};
}

Result<void> BaseSampler::load_aligned(const PlacedSource& source, const TexelRect& part, BaseChunk& chunk) const {
  const auto pitch = static_cast<std::size_t>(part.width) * source.texel_bytes;
  chunk.samples_.resize(static_cast<std::size_t>(part.height) * pitch);
  VT_CHECK(source.raster->read({part.x - source.offset_x, part.y - source.offset_y, part.width, part.height}, source.bands, chunk.samples_,
                               pitch));
  const int planes = chunk.plane_count_;
  chunk.source_planes_.resize(static_cast<std::size_t>(part.width * planes));
  for (std::int64_t row = 0; row < part.height; ++row) {
    channels::PlaneRow upper{};
    channels::ConstPlaneRow upper_const{};
    channels::PlaneRow lower{};
    for (int p = 0; p < planes; ++p) {
      const auto index = static_cast<std::size_t>(p);
      upper_const[index] = upper[index] = chunk.source_planes_.data() + p * part.width;
      lower[index] = chunk.plane_row(part.y + row - chunk.rect_.y, p) + (part.x - chunk.rect_.x);
    }
    source.codec->decode_row(chunk.samples_.data() + static_cast<std::size_t>(row) * pitch, part.width, upper);
    composite_row(upper_const, planes, part.width, lower);
  }
  return {};
}

// Bilinear between sample centres, in filter space. Beyond the outermost centres, up to the raster's edge, the edge sample is repeated.
Result<void> BaseSampler::load_resampled(const PlacedSource& source, const TexelRect& part, BaseChunk& chunk) const {
  const source::RasterInfo& info = source.raster->info();
  const auto raster_width = static_cast<double>(info.width);
  const auto raster_height = static_cast<double>(info.height);
  const auto is_inside = [&](const Point2& p) { return p.x >= 0.0 && p.y >= 0.0 && p.x <= raster_width && p.y <= raster_height; };

  // Where the texels fall, and the window of the source that holds their neighbours.
  chunk.positions_.resize(static_cast<std::size_t>(part.width * part.height));
  double min_x = std::numeric_limits<double>::infinity();
  double min_y = min_x;
  double max_x = -min_x;
  double max_y = -min_x;
  source.warp->map_centres(part, chunk.positions_);
  for (const Point2& p : chunk.positions_) {
    if (!is_inside(p)) continue;
    min_x = std::min(min_x, p.x);
    max_x = std::max(max_x, p.x);
    min_y = std::min(min_y, p.y);
    max_y = std::max(max_y, p.y);
  }
  if (!(min_x <= max_x)) return {};
  const auto sample_at = [](double v, std::int64_t size) {
    return std::clamp(static_cast<std::int64_t>(std::floor(v)), std::int64_t{0}, size - 1);
  };
  const std::int64_t x0 = sample_at(min_x - 0.5, info.width);
  const std::int64_t y0 = sample_at(min_y - 0.5, info.height);
  const source::Window window{x0, y0, sample_at(max_x + 0.5, info.width) - x0 + 1, sample_at(max_y + 0.5, info.height) - y0 + 1};

  // A rotated or much finer source makes the window large: cut the part until it is not.
  if (window.width * window.height > kMostWindowSamples && (part.width > 1 || part.height > 1)) {
    TexelRect first = part;
    TexelRect second = part;
    if (part.width >= part.height) {
      first.width /= 2;
      second.x += first.width;
      second.width -= first.width;
    } else {
      first.height /= 2;
      second.y += first.height;
      second.height -= first.height;
    }
    VT_CHECK(load_resampled(source, first, chunk));
    return load_resampled(source, second, chunk);
  }

  const int planes = chunk.plane_count_;
  const auto pitch = static_cast<std::size_t>(window.width) * source.texel_bytes;
  chunk.samples_.resize(static_cast<std::size_t>(window.height) * pitch);
  VT_CHECK(source.raster->read(window, source.bands, chunk.samples_, pitch));
  chunk.source_planes_.resize(static_cast<std::size_t>(window.width * window.height * planes));
  const auto sample_row = [&](std::int64_t y, int p) { return chunk.source_planes_.data() + (y * planes + p) * window.width; };
  for (std::int64_t y = 0; y < window.height; ++y) {
    channels::PlaneRow out{};
    for (int p = 0; p < planes; ++p) out[static_cast<std::size_t>(p)] = sample_row(y, p);
    source.codec->decode_row(chunk.samples_.data() + static_cast<std::size_t>(y) * pitch, window.width, out);
  }

  chunk.resampled_.assign(static_cast<std::size_t>(part.width * planes), 0.0F);
  for (std::int64_t row = 0; row < part.height; ++row) {
    std::fill(chunk.resampled_.begin(), chunk.resampled_.end(), 0.0F);
    for (std::int64_t i = 0; i < part.width; ++i) {
      const Point2& p = chunk.positions_[static_cast<std::size_t>(row * part.width + i)];
      if (!is_inside(p)) continue;
      const double cx = std::clamp(p.x - 0.5, 0.0, raster_width - 1.0);
      const double cy = std::clamp(p.y - 0.5, 0.0, raster_height - 1.0);
      const auto fx = static_cast<float>(cx - std::floor(cx));
      const auto fy = static_cast<float>(cy - std::floor(cy));
      const std::int64_t left = static_cast<std::int64_t>(cx) - window.x;
      const std::int64_t top = static_cast<std::int64_t>(cy) - window.y;
      const std::int64_t right = std::min(left + 1, window.width - 1);
      const std::int64_t bottom = std::min(top + 1, window.height - 1);
      for (int q = 0; q < planes; ++q) {
        const float* upper = sample_row(top, q);
        const float* lower = sample_row(bottom, q);
        const float north = upper[left] + fx * (upper[right] - upper[left]);
        const float south = lower[left] + fx * (lower[right] - lower[left]);
        chunk.resampled_[static_cast<std::size_t>(q * part.width + i)] = north + fy * (south - north);
      }
    }
    channels::ConstPlaneRow upper{};
    channels::PlaneRow lower{};
    for (int p = 0; p < planes; ++p) {
      upper[static_cast<std::size_t>(p)] = chunk.resampled_.data() + p * part.width;
      lower[static_cast<std::size_t>(p)] = chunk.plane_row(part.y + row - chunk.rect_.y, p) + (part.x - chunk.rect_.x);
    }
    composite_row(upper, planes, part.width, lower);
  }
  return {};
}

bool BaseChunk::decode_row(std::int64_t row, const channels::PlaneRow& out) const {
  if (has_samples_)
    return codec_->decode_row(samples_.data() + static_cast<std::size_t>(row * rect_.width) * texel_bytes_, rect_.width, out);
  for (int p = 0; p < plane_count_; ++p)
    std::copy_n(planes_.data() + (row * plane_count_ + p) * rect_.width, rect_.width, out[static_cast<std::size_t>(p)]);
  const float* weight = out[static_cast<std::size_t>(plane_count_ - 1)];
  return std::all_of(weight, weight + rect_.width, [](float w) { return w == 1.0F; });
}

const std::byte* BaseChunk::texel_row(std::int64_t row) const {
  return has_texels_ ? samples_.data() + static_cast<std::size_t>(row * rect_.width) * texel_bytes_ : nullptr;
}

}  // namespace vt::resample
