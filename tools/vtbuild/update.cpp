// vtbuild update: builds again what has changed in the sources of a store's layers, as they were asked for.

#include <algorithm>
#include <memory>
#include <system_error>

#include "store/store_reader.h"
#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/build_request.h"
#include "tools/vtbuild/print_plan.h"
#include "tools/vtbuild/print_report.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

struct UpdateFlags {
  std::string store;
  std::string folder;
  BuildFlags build;
};

// The recipe of every texture layer, in the order of the layers; layers of one scene have one.
Result<std::vector<Recipe>> recipes_of(const std::filesystem::path& path) {
  VT_ASSIGN(const auto reader, store::StoreReader::open(path));
  std::vector<Recipe> recipes;
  for (const LayerInfo& layer : reader.layers()) {
    if (layer.has_owner()) continue;  // built with its owner
    auto recipe = read_recipe(layer.metadata_json, path);
    if (!recipe) return fail(recipe.error().code, "layer '" + layer.name + "': " + recipe.error().message);
    const bool is_known = recipe->scene && std::ranges::any_of(recipes, [&](const Recipe& other) {
                            return other.scene == recipe->scene && other.folder == recipe->folder;
                          });
    if (!is_known) recipes.push_back(*std::move(recipe));
  }
  if (recipes.empty()) return fail(ErrorCode::kInvalidData, path.string() + ": has no layers to update");
  return recipes;
}

Result<void> check_folder(const std::filesystem::path& folder) {
  std::error_code problem;
  if (folder.empty() || std::filesystem::is_directory(folder, problem)) return {};
  return fail(ErrorCode::kIo, folder.string() + ": the store was built from sources relative to this folder, and it " +
                                  (problem ? "cannot be read: " + problem.message() : "is no folder") +
                                  "; say with --folder where they are now");
}

Result<int> run(UpdateFlags flags) {
  const std::filesystem::path store = flags.store;
  VT_ASSIGN(const std::vector<Recipe> recipes, recipes_of(store));
  flags.build.update = true;
  if (flags.build.json) flags.build.documents = std::make_shared<std::vector<nlohmann::ordered_json>>();
  for (const Recipe& recipe : recipes) {
    const std::filesystem::path folder = flags.folder.empty() ? recipe.folder : std::filesystem::path(flags.folder);
    VT_CHECK(check_folder(folder));
    VT_ASSIGN(const int done, recipe.scene ? build_scene(*recipe.scene, folder, store, flags.build)
                                           : build_asked(*recipe.asked, folder, store, flags.build));
    if (done != 0) return done;
  }
  if (!flags.build.json) return 0;
  if (flags.build.dry_run) {
    cli::print_json(joined_plans(std::move(*flags.build.documents)));
  } else {
    auto layers = nlohmann::ordered_json::array();
    for (const nlohmann::ordered_json& document : *flags.build.documents)
      for (const nlohmann::ordered_json& layer : document["layers"]) layers.push_back(layer);
    cli::print_json(report_document(flags.store, std::move(layers)));
  }
  return 0;
}

}  // namespace

std::function<Result<int>()> add_update_command(CLI::App& app) {
  auto flags = std::make_shared<UpdateFlags>();
  CLI::App* command = app.add_subcommand("update", "build again what has changed in the sources of a store's layers");
  command->add_option("STORE", flags->store, "the store; it knows how its layers were asked for")->required();
  command->add_option("--folder", flags->folder,
                      "where the sources are now, when they have moved: the folder that the commands were run in");
  flags->build.add_to(*command);
  cli::add_help_footer(*command,
                       "  vtbuild update area.vts\n"
                       "  vtbuild update area.vts --stats\n"
                       "  vtbuild update area.vts --folder /data/imagery\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::tools
