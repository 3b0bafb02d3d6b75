#include "tools/vtbuild/built_request.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/request/expand_request.h"
#include "builder/pipeline/request/option_files.h"
#include "builder/pipeline/request/scene_file.h"
#include "builder/text/json_text.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

using Json = nlohmann::ordered_json;

// The layer as the scene file describes it today: of stores that do not say how it did when they were built.
Result<pipeline::LayerRequest> scene_layer(const std::filesystem::path& scene_file, const std::string& layer) {
  VT_ASSIGN(pipeline::Scene scene, pipeline::read_scene(scene_file));
  const auto found = std::ranges::find(scene.layers, layer, &pipeline::LayerRequest::name);
  if (found == scene.layers.end() || found->sources.empty())
    return fail(ErrorCode::kNotFound, scene_file.string() + ": has no layer \"" + layer + "\" with sources any more");
  return std::move(*found);
}

// Whether a source that was asked for stands for a file of that name; a folder or a list that is gone stands
// for none.
bool stands_for(const pipeline::SourceRequest& asked, const std::filesystem::path& folder, const std::filesystem::path& name) {
  if (asked.path.filename() == name) return true;
  const auto files = pipeline::files_of(asked, folder);
  return files && std::ranges::any_of(*files, [&](const pipeline::SourceRequest& one) { return one.path.filename() == name; });
}

Result<pipeline::LayerRequest> request_from_recipe(const Recipe& recipe, const std::string& layer, const std::filesystem::path& raster) {
  pipeline::LayerRequest request;
  if (recipe.asked) {
    request = *recipe.asked;
    VT_CHECK(pipeline::load_option_files(request.channel, recipe.folder, request.options));
  } else {
    VT_ASSIGN(request, scene_layer(recipe.folder / *recipe.scene, layer));
  }
  if (request.sources.empty()) return fail(ErrorCode::kNotFound, "the layer was asked for without sources");
  const auto source = std::ranges::find_if(
      request.sources, [&](const pipeline::SourceRequest& one) { return stands_for(one, recipe.folder, raster.filename()); });
  pipeline::SourceRequest chosen = source == request.sources.end() ? request.sources.front() : *source;
  chosen.path = raster;
  request.sources = {chosen};
  return request;
}

// Members of the settings that a request has, as far as they are there.
Result<pipeline::LayerRequest> request_from_settings(const LayerInfo& layer, const Json& settings, const std::filesystem::path& raster) {
  pipeline::LayerRequest request;
  request.name = layer.name;
  request.channel = layer.channel;
  const auto text = [&](const char* name) {
    return settings.is_object() && settings.contains(name) && settings[name].is_string() ? settings[name].get<std::string>()
                                                                                         : std::string();
  };
  request.kernel = text("kernel");
  if (const auto quality = encode::quality_from_name(text("quality"))) request.quality = *quality;
  request.resample = resample::method_from_name(text("resample"));
  const Json none = Json::object();
  const Json& options = settings.is_object() && settings.contains("options") ? settings["options"] : none;
  for (const auto& [name, value] : options.items()) {
    const channels::OptionInfo* const option = channels::kind_of(layer.channel).find_option(name);
    const bool is_file = option != nullptr && option->is_file;
    // A table of classes names them and changes none.
    if (is_file && name == "classes") continue;
    if (is_file)
      return fail(ErrorCode::kUnsupported,
                  "the layer was built with the table that its option " + name + " named, which is not in the store");
    if (value.is_string()) request.options[name] = value.get<std::string>();
  }
  const Json& range = settings.is_object() && settings.contains("range") ? settings["range"] : none;
  if (range.is_array() && range.size() == 2 && range[0].is_number() && range[1].is_number())
    request.range = std::array<double, 2>{range[0].get<double>(), range[1].get<double>()};
  pipeline::SourceRequest source;
  source.path = raster;
  request.sources = {source};
  return request;
}

}  // namespace

Result<pipeline::LayerRequest> built_request(const store::StoreReader& reader, const LayerInfo& layer, const pipeline::DatasetFrame& frame,
                                             const std::filesystem::path& raster) {
  const Json metadata = text::json_or_null(layer.metadata_json);
  const Json settings = metadata.is_object() && metadata.contains("settings") ? metadata["settings"] : Json();
  const auto recipe = read_recipe(layer.metadata_json, reader.path());
  auto request = recipe ? request_from_recipe(*recipe, layer.name, raster) : request_from_settings(layer, settings, raster);
  if (!request && recipe) {
    // What the request named may be gone; most of it is in the store as well.
    auto known = request_from_settings(layer, settings, raster);
    if (known) request = std::move(known);
  }
  if (!request) return request;
  request->name = layer.name;
  request->format = layer.format;
  request->tile_texels = static_cast<int>(layer.tile_texels());
  request->area.reset();
  request->gsd_m.reset();
  request->crs.reset();
  request->expected.reset();
  request->sources.front().fallback_crs = frame.crs;
  return request;
}

}  // namespace vt::tools
