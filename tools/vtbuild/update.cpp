// vtbuild update: builds again what has changed in the sources of a store's layers, by the commands that built them.

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "store/store_reader.h"
#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/print_report.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

struct UpdateFlags {
  std::string store;
  std::string folder;
  BuildFlags build;
};

// Every different way in which a texture layer of the store was asked for, in the order of the layers.
Result<std::vector<Recipe>> recipes_of(const std::filesystem::path& path) {
  VT_ASSIGN(const auto reader, store::StoreReader::open(path));
  std::vector<Recipe> recipes;
  for (const LayerInfo& layer : reader.layers()) {
    if (layer.has_owner()) continue;  // built with its owner
    auto recipe = read_recipe(layer.metadata_json, path);
    if (!recipe) return fail(recipe.error().code, "layer '" + layer.name + "': " + recipe.error().message);
    if (std::ranges::find(recipes, *recipe) == recipes.end()) recipes.push_back(std::move(*recipe));
  }
  if (recipes.empty()) return fail(ErrorCode::kInvalidData, path.string() + ": has no layers to update");
  return recipes;
}

// As if the recipe had been typed again, with --update and this run's own options.
Result<int> run_recipe(const Recipe& recipe, const std::filesystem::path& store, const UpdateFlags& flags,
                       const std::shared_ptr<nlohmann::ordered_json>& report) {
  CLI::App app;
  app.require_subcommand(1);
  const auto layer = add_layer_command(app, report);
  const auto dataset = add_dataset_command(app, report);
  std::vector<std::string> own = {"--output=" + store.string(), "--update", "--memory=" + flags.build.memory,
                                  "--progress=" + flags.build.progress, fmt::format("--checkpoint={}", flags.build.checkpoint_seconds)};
  if (flags.build.threads > 0) own.push_back(fmt::format("--threads={}", flags.build.threads));
  if (flags.build.stats) own.emplace_back("--stats");
  if (flags.build.json) own.emplace_back("--json");
  if (flags.build.dry_run) own.emplace_back("--dry-run");
  // Right behind the subcommand: after "--" they would be inputs.
  std::vector<std::string> arguments = recipe.arguments;
  arguments.insert(arguments.begin() + 1, own.begin(), own.end());
  std::ranges::reverse(arguments);  // CLI11 takes them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& problem) {
    return fail(ErrorCode::kInvalidData, store.string() + ": the command that it was built by is not understood: " + problem.what());
  }
  VT_ASSIGN(const int done, layer());
  return done >= 0 ? done : dataset();
}

Result<int> run(const UpdateFlags& flags) {
  const std::filesystem::path store = std::filesystem::absolute(flags.store).lexically_normal();
  VT_ASSIGN(const std::vector<Recipe> recipes, recipes_of(store));
  const std::filesystem::path here = std::filesystem::current_path();
  const auto layers = flags.build.json ? std::make_shared<nlohmann::ordered_json>(nlohmann::ordered_json::array()) : nullptr;
  for (const Recipe& recipe : recipes) {
    const std::filesystem::path folder = flags.folder.empty() ? recipe.folder : here / flags.folder;
    std::error_code problem;
    std::filesystem::current_path(folder, problem);
    if (problem)
      return fail(ErrorCode::kIo, folder.string() +
                                      ": the store was built from sources relative to this folder, and it cannot be entered: " +
                                      problem.message() + "; say with --folder where they are now");
    auto done = run_recipe(recipe, store, flags, layers);
    std::filesystem::current_path(here, problem);
    VT_CHECK(done);
    if (*done != 0) return *done;
  }
  if (layers) cli::print_json(report_document(flags.store, std::move(*layers)));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_update_command(CLI::App& app) {
  auto flags = std::make_shared<UpdateFlags>();
  CLI::App* command = app.add_subcommand("update", "build again what has changed in the sources of a store's layers");
  command->add_option("STORE", flags->store, "the store; it knows the commands that built it")->required();
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
