#include "builder/resample/warped_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "builder/resample/buffers.h"

namespace vt::resample {
namespace {

bool is_inside(const source::RasterInfo& info, const Point2& p) {
  return p.x >= 0.0 && p.y >= 0.0 && p.x <= static_cast<double>(info.width) && p.y <= static_cast<double>(info.height);
}

// The samples that all `positions` need; nullopt when none lies in the raster.
std::optional<source::Window> window_around(const source::RasterInfo& info, Method method, const std::vector<Point2>& positions) {
  double min_x = std::numeric_limits<double>::infinity();
  double min_y = min_x;
  double max_x = -min_x;
  double max_y = -min_x;
  for (const Point2& p : positions) {
    if (!is_inside(info, p)) continue;
    min_x = std::min(min_x, p.x);
    max_x = std::max(max_x, p.x);
    min_y = std::min(min_y, p.y);
    max_y = std::max(max_y, p.y);
  }
  if (!(min_x <= max_x)) return std::nullopt;
  const auto sample_at = [](double v, std::int64_t size) {
    return std::clamp(static_cast<std::int64_t>(std::floor(v)), std::int64_t{0}, size - 1);
  };
  const double reach = method == Method::kBilinear ? 0.5 : 0.0;
  const std::int64_t x0 = sample_at(min_x - reach, info.width);
  const std::int64_t y0 = sample_at(min_y - reach, info.height);
  return source::Window{x0, y0, sample_at(max_x + reach, info.width) - x0 + 1, sample_at(max_y + reach, info.height) - y0 + 1};
}

// Calls use(piece, window) for pieces of `part` whose windows are small enough; `buffers.positions` are the piece's. A rotated or much
// finer source makes a window large: the part is cut until it is not.
template <class Use>
Result<void> for_each_window(const PlacedSource& source, const TexelRect& part, WarpBuffers& buffers, const Use& use) {
  refit(buffers.positions, static_cast<std::size_t>(part.width * part.height));
  source.warp->map_centres(part, buffers.positions);
  const auto window = window_around(source.raster->info(), source.method, buffers.positions);
  if (!window) return {};
  if (window->width * window->height <= kMostWindowSamples || (part.width == 1 && part.height == 1)) return use(part, *window);
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
  VT_CHECK(for_each_window(source, first, buffers, use));
  return for_each_window(source, second, buffers, use);
}

// The window's samples in filter space, into `buffers.planes`.
Result<void> decode_window(const PlacedSource& source, const source::Window& window, WarpBuffers& buffers, store::ContentHasher* content) {
  const int planes = source.codec->source_planes();
  const auto pitch = static_cast<std::size_t>(window.width) * source.layout.texel_bytes();
  refit(buffers.samples, static_cast<std::size_t>(window.height) * pitch);
  VT_CHECK(source.read(window, buffers.samples, pitch, content));
  refit(buffers.planes, static_cast<std::size_t>(window.width * window.height * planes));
  for (std::int64_t y = 0; y < window.height; ++y) {
    channels::PlaneRow out{};
    for (int p = 0; p < planes; ++p) out[static_cast<std::size_t>(p)] = buffers.planes.data() + (y * planes + p) * window.width;
    source.codec->decode_row(buffers.samples.data() + static_cast<std::size_t>(y) * pitch, window.width, out);
  }
  return {};
}

// Bilinear between sample centres. Beyond the outermost centres, up to the raster's edge, the edge sample is repeated. `count` texels at
// `positions` into `buffers.row`, plane after plane; those outside the raster stay without weight.
void interpolate_row(const source::RasterInfo& info, const source::Window& window, int planes, const Point2* positions, std::int64_t count,
                     WarpBuffers& buffers) {
  buffers.row.assign(static_cast<std::size_t>(count * planes), 0.0F);
  const auto sample_row = [&](std::int64_t y, int p) { return buffers.planes.data() + (y * planes + p) * window.width; };
  for (std::int64_t i = 0; i < count; ++i) {
    const Point2& position = positions[i];
    if (!is_inside(info, position)) continue;
    const double cx = std::clamp(position.x - 0.5, 0.0, static_cast<double>(info.width) - 1.0);
    const double cy = std::clamp(position.y - 0.5, 0.0, static_cast<double>(info.height) - 1.0);
    const auto fx = static_cast<float>(cx - std::floor(cx));
    const auto fy = static_cast<float>(cy - std::floor(cy));
    const std::int64_t left = static_cast<std::int64_t>(cx) - window.x;
    const std::int64_t top = static_cast<std::int64_t>(cy) - window.y;
    const std::int64_t right = std::min(left + 1, window.width - 1);
    const std::int64_t bottom = std::min(top + 1, window.height - 1);
    for (int p = 0; p < planes; ++p) {
      const float* upper = sample_row(top, p);
      const float* lower = sample_row(bottom, p);
      const float north = upper[left] + fx * (upper[right] - upper[left]);
      const float south = lower[left] + fx * (lower[right] - lower[left]);
      buffers.row[static_cast<std::size_t>(p * count + i)] = north + fy * (south - north);
    }
  }
}

// The sample that each centre lies in; on a border between two, the next one, so that a place belongs to one sample or to none. Layout as
// of interpolate_row.
void pick_row(const source::RasterInfo& info, const source::Window& window, int planes, const Point2* positions, std::int64_t count,
              WarpBuffers& buffers) {
  buffers.row.assign(static_cast<std::size_t>(count * planes), 0.0F);
  for (std::int64_t i = 0; i < count; ++i) {
    const Point2& place = positions[i];
    if (!is_inside(info, place) || place.x == static_cast<double>(info.width) || place.y == static_cast<double>(info.height)) continue;
    const std::int64_t x = static_cast<std::int64_t>(place.x) - window.x;
    const std::int64_t y = static_cast<std::int64_t>(place.y) - window.y;
    for (int p = 0; p < planes; ++p)
      buffers.row[static_cast<std::size_t>(p * count + i)] = buffers.planes[static_cast<std::size_t>((y * planes + p) * window.width + x)];
  }
}

}  // namespace

void composite_row(const channels::PlaneRow& upper, int planes, std::int64_t count, const channels::PlaneRow& lower) {
  const float* weight = upper[static_cast<std::size_t>(planes - 1)];
  for (int p = 0; p < planes; ++p) {
    const float* from = upper[static_cast<std::size_t>(p)];
    float* to = lower[static_cast<std::size_t>(p)];
    for (std::int64_t i = 0; i < count; ++i) to[i] = weight[i] == 1.0F ? from[i] : from[i] + (1.0F - weight[i]) * to[i];
  }
}

Result<void> composite_warped(const PlacedSource& source, const TexelRect& part, WarpBuffers& buffers, PlaneBlock& target,
                              store::ContentHasher* content) {
  return for_each_window(source, part, buffers, [&](const TexelRect& piece, const source::Window& window) -> Result<void> {
    VT_CHECK(decode_window(source, window, buffers, content));
    const int planes = source.codec->source_planes();
    for (std::int64_t row = 0; row < piece.height; ++row) {
      const Point2* positions = buffers.positions.data() + row * piece.width;
      const auto& make_row = source.method == Method::kBilinear ? interpolate_row : pick_row;
      make_row(source.raster->info(), window, planes, positions, piece.width, buffers);
      channels::PlaneRow upper{};
      for (int p = 0; p < planes; ++p) upper[static_cast<std::size_t>(p)] = buffers.row.data() + p * piece.width;
      composite_row(upper, planes, piece.width, target.row_at(piece.x, piece.y + row));
    }
    return {};
  });
}

Result<void> hash_warped(const PlacedSource& source, const TexelRect& part, WarpBuffers& buffers, store::ContentHasher& content) {
  return for_each_window(source, part, buffers,
                         [&](const TexelRect&, const source::Window& window) -> Result<void> { return source.hash(window, content); });
}

}  // namespace vt::resample
