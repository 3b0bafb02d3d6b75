// vtbuild dataset: all layers of a scene description.

#include <memory>

#include "builder/pipeline/blocks/dataset_store.h"
#include "builder/pipeline/request/scene_file.h"
#include "builder/pipeline/sources/globe_turns.h"
#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

struct DatasetFlags {
  std::string scene;
  std::string output;
  BuildFlags build;
};

Result<int> run(const DatasetFlags& flags) {
  VT_ASSIGN(const pipeline::Scene scene, pipeline::read_scene(flags.scene));
  VT_ASSIGN(std::optional<pipeline::DatasetFrame> frame, pipeline::existing_frame(flags.output));
  VT_ASSIGN(const std::size_t memory, flags.build.memory_bytes());
  if (frame && scene.crs && !frame->crs.same_coordinates(*scene.crs))
    return fail(ErrorCode::kUsage,
                flags.output + " is in " + frame->crs.text() + ", the scene in " + scene.crs->text() + "; choose another store");

  // Layers lie in the turn of the scene's area, or of those before them.
  std::optional<Area> area = scene.area;
  if (scene.area && (frame || scene.crs)) {
    VT_ASSIGN(area, pipeline::normalised(*scene.area, frame ? frame->crs : *scene.crs));
  }
  if (!frame && scene.crs) frame = pipeline::DatasetFrame{*scene.crs, std::nullopt, area};
  // Without a declared one, the first layer decides the coordinate reference system of all.
  std::vector<pipeline::LayerPlan> plans;
  for (const pipeline::LayerRequest& request : scene.layers) {
    VT_ASSIGN(pipeline::LayerPlan plan, pipeline::plan_layer(request, frame, flags.build.plan_options(memory, flags.output)));
    if (!frame) frame = pipeline::DatasetFrame{plan.crs, std::nullopt};
    if (scene.area && !scene.crs && plans.empty()) {
      VT_ASSIGN(area, pipeline::normalised(*scene.area, plan.crs));
    }
    if (!scene.area) area = area ? pipeline::united(*area, plan.extent()) : plan.extent();
    if (!frame->area) frame->planned = area;
    plans.push_back(std::move(plan));
  }
  return build_layers(flags.output, std::move(plans), *area, flags.build);
}

}  // namespace

std::function<Result<int>()> add_dataset_command(CLI::App& app, std::shared_ptr<nlohmann::ordered_json> report) {
  auto flags = std::make_shared<DatasetFlags>();
  flags->build.report = std::move(report);
  CLI::App* command = app.add_subcommand("dataset", "build all layers of a scene description (SCENE.json)");
  command->add_option("SCENE", flags->scene, "the description; schemas/dataset.schema.json says what it may hold")->required();
  command->add_option("-o,--output", flags->output, "the store, suffix .vts")->required();
  flags->build.add_to(*command);
  cli::add_help_footer(*command,
                       "  vtbuild dataset sample/SCENE.json -o sample.vts\n"
                       "  vtbuild dataset sample/SCENE.json -o sample.vts --dry-run\n");
  return [flags, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    flags->build.recipe = recipe_of(*command, flags->output);
    VT_CHECK(check_recipe(flags->build.recipe));
    return run(*flags);
  };
}

}  // namespace vt::tools
