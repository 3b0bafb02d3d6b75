#include "builder/pipeline/source_load.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "builder/pipeline/tiers.h"
#include "builder/resample/warped_reader.h"

namespace vt::pipeline {

std::size_t SourceLoad::chunk_bytes(std::int64_t width, int planes) const {
  const auto texels = static_cast<std::size_t>(width * kChunkRows);
  const std::size_t texel_planes = static_cast<std::size_t>(planes) * sizeof(float);
  std::size_t bytes = texels * texel_bytes;
  if (has_planes) bytes += (texels + static_cast<std::size_t>(width)) * texel_planes;
  if (has_warped)
    bytes += texels * sizeof(Point2) + static_cast<std::size_t>(resample::kMostWindowSamples) * (texel_bytes + texel_planes) +
             static_cast<std::size_t>(width) * texel_planes;
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
    // Of what a reader holds about a third is the block as it is stored; the rest goes when the read ends.
    if (info.compression != "none")
      load.stored_block_bytes = std::max(load.stored_block_bytes, sources[i].raster->resident_bytes() * 2 / 5);
    load.texel_bytes = std::max(load.texel_bytes, places[i].placed.front().layout.texel_bytes());
    load.has_pictures = load.has_pictures || info.is_picture;
    load.has_warped =
        load.has_warped || std::ranges::any_of(places[i].placed, [](const resample::PlacedSource& p) { return !p.is_aligned; });
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
