// Which samples of a source a layer reads, and what they mean to it: bands, coverage, no-data values, full
// scales, scale and unit. What the user says goes before what the file says. Nothing is read; any thread.
#pragma once

#include <vector>

#include "builder/channels/samples/sample_layout.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/open_sources.h"
#include "store/result.h"

namespace vt::pipeline {

struct ChosenSamples {
  std::vector<int> bands;  // indices into the raster's: values, then the coverage when the layout has one
  channels::SampleLayout layout;
};

// kUsage: a band that the file does not have; no-data values of another number than there are bands.
[[nodiscard]] Result<ChosenSamples> choose_samples(const LayerRequest& request, const OpenSource& source);

}  // namespace vt::pipeline
