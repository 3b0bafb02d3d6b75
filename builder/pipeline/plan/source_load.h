// What reading a layer's sources takes, for counting memory before a build. Arithmetic only; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/channels/codec/channel_codec.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/open_sources.h"
#include "builder/pipeline/sources/place_source.h"
#include "store/layer.h"

namespace vt::pipeline {

struct SourceLoad {
  std::size_t count = 0;
  std::uint64_t sample_bytes = 0;      // all samples of all sources, decoded
  std::uint64_t file_blocks = 0;       // tiles and strips of all files
  std::size_t cache_bytes = 0;         // decoded blocks that are kept at most
  std::size_t reader_bytes = 0;        // of one thread inside a read, at most
  std::size_t stored_block_bytes = 0;  // the largest compressed block that a decoder holds
  std::size_t texel_bytes = 0;         // of the widest sample layout
  bool has_pictures = false;           // some are read through the picture library
  bool has_planes = false;             // some rectangles have to be put together in filter space
  bool has_warped = false;             // some sources are resampled
  bool counts_areas = false;           // and texels are of several classes
  std::int64_t longest_footprint = 0;  // samples under one texel, along one axis of a source that is resampled

  // Buffers for the rows that are read at once, `width` texels wide.
  [[nodiscard]] std::size_t chunk_bytes(std::int64_t width, const channels::ChannelCodec& codec) const;
};

// `places` belong to `sources` one by one.
[[nodiscard]] SourceLoad load_of(const std::vector<OpenSource>& sources, const std::vector<SourcePlaces>& places, const LayerInfo& layer,
                                 std::size_t cache_bytes);
// The load of sources that are not there yet.
[[nodiscard]] SourceLoad expected_load(const LayerRequest& request, const channels::SampleLayout& layout, const LayerInfo& info,
                                       std::size_t cache_bytes);

}  // namespace vt::pipeline
