// A layer request as JSON, by the definition "layer" of schemas/dataset.schema.json: in scene files, and in
// the metadata of a layer that was built. The one reader and the one writer. Requests here are as they were
// asked for, see expand_request.h. Pure functions, any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"

namespace vt::pipeline {

// The rectangle of the definition "area".
[[nodiscard]] Area area_from_json(const nlohmann::json& area);

// What `layer` asks for; it has passed the schema. `where` is its place, for messages:
// "SCENE.json: at /layers/0".
[[nodiscard]] Result<LayerRequest> layer_from_json(const nlohmann::json& layer, const std::string& where);

// The same reading of a layer that stands alone, which is checked against the schema first.
[[nodiscard]] Result<LayerRequest> request_from_json(const nlohmann::json& layer, const std::string& where);

// The inverse of layer_from_json(). `folder` is put before relative paths, so that they may be read from
// another place. kUnsupported: a coordinate reference system without an EPSG code.
[[nodiscard]] Result<nlohmann::ordered_json> request_json(const LayerRequest& asked, const std::filesystem::path& folder = {});

}  // namespace vt::pipeline
