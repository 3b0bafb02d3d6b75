// Horizons of which neither the file nor the user says a unit are taken as radians. Numbers that are no such angles would leave texels
// without data, so what looks like degrees is refused before anything is built.
#pragma once

#include <span>

#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/place_source.h"

namespace vt::pipeline {

// Of other channels nothing. kInvalidData: the numbers of a source look like degrees. Otherwise the errors of reading.
[[nodiscard]] Result<void> check_horizon_unit(const LayerRequest& request, std::span<const SourcePlaces> sources);

}  // namespace vt::pipeline
