// What a layer's metadata say of its numbers and of their errors (builder/pipeline/blocks/block_quality.h
// writes it), as text. Metadata are for tools and may be anything: what is not there or not of its type is
// left out.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "store/layer.h"

namespace vt::inspect {

// The names of the components; empty when the metadata have none.
[[nodiscard]] std::vector<std::string> component_names(const nlohmann::ordered_json& metadata);
// The unit of the values: the metadata's, else the channel's.
[[nodiscard]] std::string unit_of(const LayerInfo& layer, const nlohmann::ordered_json& metadata);

// A table of the errors of every level, finest first, one for each measure; "" when nothing was measured.
[[nodiscard]] std::string quality_table(const nlohmann::ordered_json& metadata);

}  // namespace vt::inspect
