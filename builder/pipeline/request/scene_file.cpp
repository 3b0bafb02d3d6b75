#include "builder/pipeline/request/scene_file.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "builder/pipeline/request/dataset_schema.h"
#include "builder/pipeline/request/expand_request.h"
#include "builder/pipeline/request/request_json.h"
#include "builder/text/json_text.h"
#include "builder/text/text_file.h"

namespace vt::pipeline {

using nlohmann::json;

Result<Scene> read_scene(const std::filesystem::path& path) {
  VT_ASSIGN(const std::string content, text::read_text_file(path, text::kMaxJsonBytes));
  auto parsed = text::parse_json(content);
  if (!parsed) return fail(parsed.error().code, path.string() + ": " + parsed.error().message);
  const json document = std::move(*parsed);
  VT_CHECK(check_against_dataset_schema(document, path.string()));

  Scene scene;
  scene.name = document.value("name", path.stem().string());
  if (document.contains("crs")) {
    auto crs = geo::Crs::from_text(document["crs"].get<std::string>());
    if (!crs) return fail(crs.error().code, path.string() + ": at /crs: " + crs.error().message);
    scene.crs = *std::move(crs);
  }
  if (document.contains("area")) scene.area = area_from_json(document["area"]);
  std::size_t index = 0;
  for (const json& layer : document.at("layers")) {
    const std::string where = path.string() + ": at /layers/" + std::to_string(index++);
    VT_ASSIGN(LayerRequest asked, layer_from_json(layer, where));
    if (!asked.crs) asked.crs = scene.crs;
    // A layer that is planned before its sources are there covers the dataset.
    if (asked.expected && !asked.area) asked.area = scene.area;
    for (const LayerRequest& other : scene.layers)
      if (other.name == asked.name) return fail(ErrorCode::kInvalidData, where + "/name: '" + asked.name + "' is used twice");
    VT_ASSIGN(LayerRequest request, expand_request(asked, path.parent_path(), where));
    scene.layers.push_back(std::move(request));
    scene.asked.push_back(std::move(asked));
  }
  return scene;
}

}  // namespace vt::pipeline
