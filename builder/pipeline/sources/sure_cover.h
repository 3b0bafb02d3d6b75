// Whether a layer can have texels without data. Plain values; any thread.
#pragma once

#include <span>

#include "builder/geo/crs.h"
#include "builder/pipeline/sources/open_sources.h"
#include "builder/pipeline/sources/place_source.h"
#include "store/layer.h"

namespace vt::pipeline {

// Every texel of the layer's data rectangle surely has data: sources whose samples cannot be without (no
// coverage, no declared nodata, no floats, of which any may be NaN) and whose columns and rows run along the
// layer's tile it wholly. False is not certain: a source that is turned or in another system may well cover
// all of it. `places[i]` are those of `sources[i]`.
[[nodiscard]] bool is_surely_covered(const LayerInfo& layer, const geo::Crs& crs, std::span<const OpenSource> sources,
                                     std::span<const SourcePlaces> places);

}  // namespace vt::pipeline
