// How small the light of an illumination layer is, for formats with the range of a half: from a look at its
// sources.
#pragma once

#include <span>

#include "builder/pipeline/sources/place_source.h"
#include "store/result.h"

namespace vt::pipeline {

// The light that the stored number 1 should mean. It is 1 as long as halves hold the sources' light; where
// more than a thousandth of it, or its mean, lies below the least normal half, it is the power of two that
// puts the brightest light seen just below 1024: six octaves are left for brighter lamps, 24 for darker ones.
//
// Looks at a few windows, evenly spread over at most 64 sources, so what it costs does not grow with them,
// and the same sources always give the same scale. All sources have their codecs; what these make of samples
// is light. Errors as RasterSource::read.
[[nodiscard]] Result<double> choose_stored_light(std::span<const SourcePlaces> sources);

}  // namespace vt::pipeline
