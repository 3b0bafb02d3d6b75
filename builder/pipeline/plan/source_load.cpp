#include "builder/pipeline/plan/source_load.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "builder/pipeline/plan/tiers.h"
#include "builder/resample/warped_reader.h"

namespace vt::pipeline {
namespace {

// A texel's list of classes and areas, about four classes long.
constexpr std::size_t kClassAreaBytes = 96;

}  // namespace

std::size_t SourceLoad::chunk_bytes(std::int64_t width, const channels::ChannelCodec& codec) const {
  const auto texels = static_cast<std::size_t>(width * kChunkRows);
  const std::size_t texel_planes = static_cast<std::size_t>(codec.planes()) * sizeof(float);
  std::size_t bytes = texels * texel_bytes;
  if (has_planes) bytes += (texels + static_cast<std::size_t>(width)) * texel_planes;
  if (!has_warped) return bytes;
  // Each texel has its centre and a corner in the source, samples per texel and the way it is made; of each
  // column what it is made of.
  bytes += texels * (2 * sizeof(Point2) + sizeof(float) + 1) + static_cast<std::size_t>(width) * (texel_planes + 2 * sizeof(std::uint64_t));
  const auto samples = static_cast<std::size_t>(std::max(resample::kMostWindowSamples, longest_footprint));
  bytes += samples * (texel_bytes + texel_planes + 1);
  bytes += (static_cast<std::size_t>(resample::kMostSums) + static_cast<std::size_t>(longest_footprint) * texel_planes) * sizeof(double);
  // In a mosaic each grid is made by itself before it is laid over the others.
  if (count > 1) bytes += texels * (texel_planes + 2 * (sizeof(std::uint64_t) + 1));
  // Lists of classes, of the footprints in work and of the texels that are done.
  if (counts_areas)
    bytes += texels * (count > 1 ? 2 : 1) * kClassAreaBytes + static_cast<std::size_t>(resample::kMostSums) * kClassAreaBytes;
  return bytes;
}

SourceLoad load_of(const std::vector<OpenSource>& sources, const std::vector<SourcePlaces>& places, const LayerInfo& layer,
                   std::size_t cache_bytes) {
  SourceLoad load;
  load.count = sources.size();
  load.cache_bytes = cache_bytes;
  const auto blocks = [](std::int64_t size, std::int64_t block) { return static_cast<std::uint64_t>((size + block - 1) / block); };
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const source::RasterInfo& info = sources[i].raster->info();
    const std::size_t sample = sample_bytes(info.sample_type) * static_cast<std::size_t>(info.bands);
    load.sample_bytes += static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height) * sample;
    load.file_blocks += blocks(info.width, info.block_width) * blocks(info.height, info.block_height);
    load.reader_bytes = std::max(load.reader_bytes, sources[i].raster->resident_bytes());
    // About a third of what a reader holds is the block as it is stored; the rest goes when the read ends.
    if (info.compression != "none")
      load.stored_block_bytes = std::max(load.stored_block_bytes, sources[i].raster->resident_bytes() * 2 / 5);
    load.texel_bytes = std::max(load.texel_bytes, places[i].placed.front().layout.texel_bytes());
    load.has_pictures = load.has_pictures || info.is_picture;
    for (const resample::PlacedSource& placed : places[i].placed) {
      if (placed.is_aligned) continue;
      load.has_warped = true;
      const double samples = std::ceil(placed.warp->most_samples_per_texel(placed.covered)) + 1.0;
      load.longest_footprint =
          std::max(load.longest_footprint, static_cast<std::int64_t>(std::min(samples, static_cast<double>(info.width))));
    }
  }
  const resample::PlacedSource& first = places.front().placed.front();
  const bool is_one_and_whole = sources.size() == 1 && places.front().placed.size() == 1 && first.is_aligned &&
                                first.covered == TexelRect{0, 0, layer.data.width, layer.data.height};
  load.has_planes = !is_one_and_whole;
  return load;
}

// A source as it is usually made: tiles of 256 x 256, compressed, on the layer's own grid.
SourceLoad expected_load(const LayerRequest& request, const channels::SampleLayout& layout, const LayerInfo& info,
                         std::size_t cache_bytes) {
  constexpr std::uint64_t kTileSamples = 256 * 256;
  const std::uint64_t texels = static_cast<std::uint64_t>(info.data.width) * static_cast<std::uint64_t>(info.data.height);
  SourceLoad load;
  load.count = std::max<std::size_t>(request.sources.size(), 1);
  load.texel_bytes = layout.texel_bytes();
  load.sample_bytes = texels * load.texel_bytes;
  load.file_blocks = texels / kTileSamples + 1;
  load.cache_bytes = cache_bytes;
  load.stored_block_bytes = kTileSamples * load.texel_bytes;
  load.reader_bytes = std::max<std::size_t>(4 * load.stored_block_bytes, std::size_t{1} << 20);
  load.has_planes = load.count > 1;
  return load;
}

}  // namespace vt::pipeline
