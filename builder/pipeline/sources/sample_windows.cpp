#include "builder/pipeline/sources/sample_windows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace vt::pipeline {
namespace {

constexpr std::size_t kMostLookedAt = 64;
constexpr std::size_t kMostWindows = 64;
constexpr std::int64_t kWindowEdge = 64;

// Places of windows along one axis of a raster, evenly spread, the first and the last at its ends.
std::vector<std::int64_t> window_places(std::int64_t length, std::int64_t wanted) {
  const std::int64_t last = std::max<std::int64_t>(length - kWindowEdge, 0);
  const std::int64_t count = std::clamp<std::int64_t>((length + kWindowEdge - 1) / kWindowEdge, 1, wanted);
  std::vector<std::int64_t> result;
  for (std::int64_t i = 0; i < count; ++i) result.push_back(count == 1 ? last / 2 : last * i / (count - 1));
  return result;
}

}  // namespace

Result<void> look_at_windows(std::span<const SourcePlaces> sources, const LookAt& look) {
  const std::size_t looked_at = std::min(sources.size(), kMostLookedAt);
  const auto windows_across = std::max<std::int64_t>(1, std::llround(std::sqrt(static_cast<double>(kMostWindows / looked_at))));
  for (std::size_t i = 0; i < looked_at; ++i) {
    const resample::PlacedSource& source = sources[i * sources.size() / looked_at].placed.front();
    const source::RasterInfo& info = source.raster->info();
    for (const std::int64_t y : window_places(info.height, windows_across))
      for (const std::int64_t x : window_places(info.width, windows_across))
        VT_CHECK(look(source, {x, y, std::min(kWindowEdge, info.width - x), std::min(kWindowEdge, info.height - y)}));
  }
  return {};
}

}  // namespace vt::pipeline
