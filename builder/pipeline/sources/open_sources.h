// The files behind a layer, opened and known: what they hold, where they say they lie, which content they
// have.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/source/cells/block_cache.h"
#include "builder/source/cells/scratch_file.h"
#include "builder/source/files/file_pool.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::pipeline {

struct OpenSource {
  SourceRequest request;
  std::shared_ptr<const source::RasterSource> raster;
  geo::Crs crs;
  geo::GeoTransform transform;  // of a picture without a place: its lower left corner at (0, 0), one unit a sample
  std::string fingerprint;      // of the file's content
};

// What all sources of a layer share.
struct SharedReading {
  std::shared_ptr<source::BlockCache> cache;     // decoded blocks
  std::shared_ptr<source::FilePool> files;       // descriptors and decoders
  std::shared_ptr<source::ScratchFile> scratch;  // null: none
};

// Those of a layer, in order, on `threads` threads. Errors name the file and say which option helps; of
// several, all in one, see ErrorList.
[[nodiscard]] Result<std::vector<OpenSource>> open_sources(const LayerRequest& layer, const SharedReading& shared, int threads);

}  // namespace vt::pipeline
