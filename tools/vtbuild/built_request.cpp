#include "tools/vtbuild/built_request.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/request/scene_file.h"
#include "builder/text/json_text.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

using Json = nlohmann::ordered_json;

// The current folder for as long as this lives.
class InFolder {
 public:
  explicit InFolder(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder, problem_);
  }
  InFolder(const InFolder&) = delete;
  InFolder& operator=(const InFolder&) = delete;
  ~InFolder() {
    std::error_code ignored;
    std::filesystem::current_path(before_, ignored);
  }
  [[nodiscard]] const std::error_code& problem() const { return problem_; }

 private:
  std::filesystem::path before_;
  std::error_code problem_;
};

Result<pipeline::LayerRequest> scene_request(const std::filesystem::path& scene_file, const std::string& layer,
                                             const std::filesystem::path& raster) {
  VT_ASSIGN(pipeline::Scene scene, pipeline::read_scene(scene_file));
  const auto found = std::ranges::find(scene.layers, layer, &pipeline::LayerRequest::name);
  if (found == scene.layers.end() || found->sources.empty())
    return fail(ErrorCode::kNotFound, scene_file.string() + ": has no layer \"" + layer + "\" with sources any more");
  const auto source =
      std::ranges::find_if(found->sources, [&](const pipeline::SourceRequest& one) { return one.path.filename() == raster.filename(); });
  pipeline::SourceRequest chosen = source == found->sources.end() ? found->sources.front() : *source;
  chosen.path = raster;
  found->sources = {chosen};
  return *found;
}

Result<pipeline::LayerRequest> request_from_recipe(const Recipe& recipe, const std::string& layer, const pipeline::DatasetFrame& frame,
                                                   const std::filesystem::path& raster) {
  const InFolder folder(recipe.folder);
  if (folder.problem())
    return fail(ErrorCode::kIo,
                recipe.folder.string() + ": the layer was built from this folder, and it cannot be entered: " + folder.problem().message());
  if (recipe.arguments.front() == "layer") return layer_request_of(recipe.arguments, raster, frame);
  // `dataset SCENE`, and options that begin with a dash; a scene that does so, too, comes behind "--".
  auto scene = std::ranges::find(recipe.arguments, "--");
  if (scene != recipe.arguments.end()) {
    ++scene;
  } else {
    scene = std::find_if(recipe.arguments.begin() + 1, recipe.arguments.end(),
                         [](const std::string& argument) { return !argument.starts_with('-'); });
  }
  if (scene == recipe.arguments.end()) return fail(ErrorCode::kInvalidData, "the command that the layer was built by names no scene");
  return scene_request(*scene, layer, raster);
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
  const std::filesystem::path whole = std::filesystem::absolute(raster);
  const Json metadata = text::json_or_null(layer.metadata_json);
  const Json settings = metadata.is_object() && metadata.contains("settings") ? metadata["settings"] : Json();
  const auto recipe = read_recipe(layer.metadata_json, reader.path());
  auto request = recipe ? request_from_recipe(*recipe, layer.name, frame, whole) : request_from_settings(layer, settings, whole);
  if (!request && recipe) {
    // What the command named may be gone; most of it is in the store as well.
    auto known = request_from_settings(layer, settings, whole);
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
