// The check of a document against schemas/dataset.schema.json, which is compiled in: what the program checks
// is what the document says. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "store/result.h"

namespace vt::pipeline {

// `where` names the document in messages. kInvalidData names the JSON path and what is wanted there.
[[nodiscard]] Result<void> check_against_dataset_schema(const nlohmann::json& document, const std::string& where);

// The same check of a layer that stands alone.
[[nodiscard]] Result<void> check_against_layer_schema(const nlohmann::json& layer, const std::string& where);

}  // namespace vt::pipeline
