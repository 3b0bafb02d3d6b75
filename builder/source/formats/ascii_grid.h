// Esri ASCII grids: a header of words with numbers, then the samples as decimal numbers, row by row from the
// north. The file is walked through once when it is opened, to count its samples, to choose a type that holds
// them, and to note where rows begin.
#pragma once

#include <memory>

#include "builder/source/files/file_bytes.h"
#include "builder/source/files/file_evidence.h"
#include "builder/source/raster_source.h"
#include "store/result.h"

namespace vt::source {

[[nodiscard]] bool is_ascii_grid(const FileEvidence& file);

// Samples are int16, int32, float32 or float64: the first of these that keeps every number as it is written.
[[nodiscard]] Result<std::unique_ptr<RasterSource>> open_ascii_grid(std::shared_ptr<const FileBytes> file, const OpenOptions& options);

}  // namespace vt::source
