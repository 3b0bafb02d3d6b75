// Whether a source can lie where it is said to lie: which CRS counts, and whether its coordinates are
// possible in it. What is wrong is told with what was found in the file and with what helps for that file.
#pragma once

#include <optional>

#include "builder/geo/crs.h"
#include "builder/pipeline/sources/open_sources.h"
#include "store/result.h"

namespace vt::pipeline {

// The CRS that a file is in. A CRS that the file declares is overruled by SourceRequest::crs and by nothing
// else, whether we know it or not. `info` is the file's, opened with the request's options. kUnsupported: the
// file declares a CRS that we do not know. kInvalidData: none is known, or two are said.
[[nodiscard]] Result<geo::Crs> crs_of_source(const SourceRequest& request, const source::RasterInfo& info);

// Degrees are degrees: samples lie on latitudes from -90 to 90 and longitudes from -540 to 540; and a
// projected raster's middle is a place on the Earth. kInvalidData.
[[nodiscard]] Result<void> check_place(const OpenSource& source);

// A projected raster whose coordinates are so small and so fine that they seem to be degrees.
[[nodiscard]] bool looks_like_degrees(const OpenSource& source);

}  // namespace vt::pipeline
