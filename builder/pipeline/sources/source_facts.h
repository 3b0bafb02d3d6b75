// What a layer remembers of its sources, to know whether a later run may share its work.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "builder/pipeline/sources/open_sources.h"
#include "builder/pipeline/sources/place_source.h"

namespace vt::pipeline {

// What decides the samples and their place, for the layer's settings; `places` belong to `sources` one by
// one. A long list is given as its length and a hash of all of it: the settings are part of the store and
// written with every checkpoint.
[[nodiscard]] nlohmann::ordered_json facts_of(const std::vector<OpenSource>& sources, const std::vector<SourcePlaces>& places);

}  // namespace vt::pipeline
