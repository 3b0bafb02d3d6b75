// SCENE.json: the description of a whole dataset. Read, checked against schemas/dataset.schema.json, and
// turned into layer requests.
#pragma once

#include <filesystem>
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
  std::vector<LayerRequest> layers;  // as they can be planned
  std::vector<LayerRequest> asked;   // the same as they stand in the file, see expand_request.h; paths are relative to the file
};

// Paths in the file are relative to the file. kIo when it cannot be read; kInvalidData names the JSON path,
// what was found and what is wanted.
[[nodiscard]] Result<Scene> read_scene(const std::filesystem::path& path);

}  // namespace vt::pipeline
