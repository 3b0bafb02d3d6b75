// SCENE.json: the description of a whole dataset. Read, checked against schemas/dataset.schema.json, and turned into layer requests.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"

namespace vt::pipeline {

struct Scene {
  std::string name;
  std::optional<geo::Crs> crs;
  std::optional<Area> area;
  std::vector<LayerRequest> layers;
};

// Paths in the file are relative to the file. kIo when it cannot be read; kInvalidData names the JSON path, what was found and what is
// wanted.
[[nodiscard]] Result<Scene> read_scene(const std::filesystem::path& path);

// The check alone. `where` names the document in messages.
[[nodiscard]] Result<void> check_against_dataset_schema(const nlohmann::json& document, const std::string& where);

}  // namespace vt::pipeline
