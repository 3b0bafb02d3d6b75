// What samples cannot be is refused before anything is built, as far as a look at some of them shows it.
#pragma once

#include <span>

#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/place_source.h"

namespace vt::pipeline {

// Asks the channel, see ChannelKind::check_samples. kInvalidData: the numbers of a source are not the
// channel's. Otherwise the errors of reading.
[[nodiscard]] Result<void> check_samples(const LayerRequest& request, std::span<const SourcePlaces> sources);

}  // namespace vt::pipeline
