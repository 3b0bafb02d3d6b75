// Some windows of a layer's sources, for what has to be known before anything is built: up to 64 of 64 x 64
// samples, evenly spread over the sources and over each of them. The same sources give the same windows.
#pragma once

#include <functional>
#include <span>

#include "builder/pipeline/sources/place_source.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::pipeline {

using LookAt = std::function<Result<void>(const resample::PlacedSource& source, const source::Window& window)>;

// On the caller's thread. Any error is that of `look`.
[[nodiscard]] Result<void> look_at_windows(std::span<const SourcePlaces> sources, const LookAt& look);

}  // namespace vt::pipeline
