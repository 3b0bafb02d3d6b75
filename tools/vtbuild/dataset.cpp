// vtbuild dataset: all layers of a scene description.

#include <memory>

#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/build_request.h"

namespace vt::tools {

std::function<Result<int>()> add_dataset_command(CLI::App& app) {
  struct DatasetFlags {
    std::string scene;
    std::string output;
    BuildFlags build;
  };
  auto flags = std::make_shared<DatasetFlags>();
  CLI::App* command = app.add_subcommand("dataset", "build all layers of a scene description (SCENE.json)");
  command->add_option("SCENE", flags->scene, "the description; schemas/dataset.schema.json says what it may hold")->required();
  command->add_option("-o,--output", flags->output, "the store, suffix .vts")->required();
  flags->build.add_to(*command);
  cli::add_help_footer(*command,
                       "  vtbuild dataset sample/SCENE.json -o sample.vts\n"
                       "  vtbuild dataset sample/SCENE.json -o sample.vts --dry-run\n");
  return [flags, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    return build_scene(flags->scene, {}, flags->output, flags->build);
  };
}

}  // namespace vt::tools
