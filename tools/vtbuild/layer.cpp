// vtbuild layer: one layer from one or more rasters.

#include <memory>

#include "tools/cli/setting_names.h"
#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/build_request.h"
#include "tools/vtbuild/layer_flags.h"

namespace vt::tools {

std::function<Result<int>()> add_layer_command(CLI::App& app) {
  auto flags = std::make_shared<LayerFlags>();
  auto build = std::make_shared<BuildFlags>();
  CLI::App* command = app.add_subcommand("layer", "build one layer from georeferenced rasters, into a new store or one that exists");
  flags->add_to(*command);
  command->get_option("--output")->required();
  build->add_to(*command);
  cli::put_flags_in_help(*command);
  cli::add_help_footer(*command,
                       "  vtbuild layer ortho.tif -o area.vts --channel color\n"
                       "  vtbuild layer dem.tif -o area.vts --channel elevation\n"
                       "  vtbuild layer tiles/ -o area.vts --channel color\n"
                       "  vtbuild layer @tiles.txt -o area.vts --channel color\n"
                       "  vtbuild layer west.tif east.tif -o area.vts --channel color --format bc1 --compression zstd:9\n"
                       "  vtbuild layer earth.jpg -o earth.vts --channel color --crs EPSG:4326 --extent -180,-90,180,90\n"
                       "  vtbuild layer scan.png -o scan.vts --channel color --crs pixel\n");
  return [flags, build, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    VT_ASSIGN(const pipeline::LayerRequest asked, asked_request(*flags));
    return build_asked(asked, {}, flags->output, *build);
  };
}

}  // namespace vt::tools
