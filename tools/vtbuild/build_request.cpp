#include "tools/vtbuild/build_request.h"

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "builder/pipeline/blocks/dataset_store.h"
#include "builder/pipeline/request/expand_request.h"
#include "builder/pipeline/request/scene_file.h"
#include "builder/pipeline/sources/globe_turns.h"
#include "tools/cli/setting_names.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

// Settings that a scene file has under another name than flags.
constexpr std::array<std::pair<std::string_view, std::string_view>, 1> kSceneKeys = {{{"source-crs", "source_crs"}}};

Result<int> build_layers_of(const pipeline::Scene& scene, const std::filesystem::path& file, const std::filesystem::path& folder,
                            const std::filesystem::path& store, const BuildFlags& flags) {
  if (!flags.update)
    for (const pipeline::LayerRequest& layer : scene.layers) VT_CHECK(pipeline::check_range(layer));
  VT_ASSIGN(std::optional<pipeline::DatasetFrame> frame, pipeline::existing_frame(store));
  VT_ASSIGN(const std::size_t memory, flags.memory_bytes());
  if (frame && scene.crs && !frame->crs.same_coordinates(*scene.crs))
    return fail(ErrorCode::kUsage,
                store.string() + " is in " + frame->crs.text() + ", the scene in " + scene.crs->text() + "; choose another store");

  // Layers lie in the turn of the scene's area, or of those before them.
  std::optional<Area> area = scene.area;
  if (scene.area && (frame || scene.crs)) {
    VT_ASSIGN(area, pipeline::normalised(*scene.area, frame ? frame->crs : *scene.crs));
  }
  if (!frame && scene.crs) frame = pipeline::DatasetFrame{*scene.crs, std::nullopt, area};
  // Without a declared one, the first layer decides the coordinate reference system of all.
  std::vector<pipeline::LayerPlan> plans;
  for (std::size_t i = 0; i < scene.layers.size(); ++i) {
    VT_ASSIGN(pipeline::LayerPlan plan, pipeline::plan_layer(scene.layers[i], frame, flags.plan_options(memory, store)));
    VT_ASSIGN(plan.recipe, scene_recipe_json(file, scene.asked[i], folder, store));
    if (!frame) frame = pipeline::DatasetFrame{plan.crs, std::nullopt};
    if (scene.area && !scene.crs && plans.empty()) {
      VT_ASSIGN(area, pipeline::normalised(*scene.area, plan.crs));
    }
    if (!scene.area) area = area ? pipeline::united(*area, plan.extent()) : plan.extent();
    if (!frame->area) frame->planned = area;
    plans.push_back(std::move(plan));
  }
  return build_layers(store, std::move(plans), *area, flags);
}

}  // namespace

Result<int> build_asked(const pipeline::LayerRequest& asked, const std::filesystem::path& folder, const std::filesystem::path& store,
                        const BuildFlags& flags) {
  if (!flags.update) VT_CHECK(pipeline::check_range(asked));
  VT_ASSIGN(nlohmann::ordered_json recipe, recipe_json(asked, folder, store));
  VT_ASSIGN(const auto frame, pipeline::existing_frame(store));
  if (frame && asked.crs && !frame->crs.same_coordinates(*asked.crs))
    return fail(ErrorCode::kUsage, store.string() + " is in " + frame->crs.text() + "; its layers cannot be in " + asked.crs->text());
  VT_ASSIGN(const pipeline::LayerRequest request, pipeline::expand_request(asked, folder));
  VT_ASSIGN(const std::size_t memory, flags.memory_bytes());
  VT_ASSIGN(pipeline::LayerPlan plan, pipeline::plan_layer(request, frame, flags.plan_options(memory, store)));
  plan.recipe = std::move(recipe);
  const Area extent = plan.extent();
  std::vector<pipeline::LayerPlan> plans;
  plans.push_back(std::move(plan));
  return build_layers(store, std::move(plans), extent, flags);
}

Result<int> build_scene(const std::filesystem::path& scene_file, const std::filesystem::path& folder, const std::filesystem::path& store,
                        const BuildFlags& flags) {
  VT_ASSIGN(const pipeline::Scene scene, pipeline::read_scene(folder / scene_file));
  auto built = build_layers_of(scene, scene_file, folder, store, flags);
  if (!built) return fail(built.error().code, cli::with_other_names(built.error().message, kSceneKeys));
  return built;
}

}  // namespace vt::tools
