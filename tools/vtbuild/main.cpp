// vtbuild: from rasters to a tile store.

#include "tools/vtbuild/build_flags.h"

int main(int argc, char** argv) {
  CLI::App app("Builds virtual-texture stores from georeferenced rasters.", "vtbuild");
  app.set_version_flag("--version", "vtbuild " VT_VERSION);
  app.require_subcommand(1);
  const std::vector<std::function<vt::Result<int>()>> commands = {
      vt::tools::add_layer_command(app),  vt::tools::add_dataset_command(app), vt::tools::add_sample_command(app),
      vt::tools::add_update_command(app), vt::tools::add_pack_command(app),    vt::tools::add_remove_command(app),
  };
  vt::cli::add_help_footer(app,
                           "  vtbuild sample -o sample                                   a scene to try\n"
                           "  vtbuild dataset sample/SCENE.json -o sample.vts            all its layers\n"
                           "  vtbuild layer ortho.tif -o area.vts --channel color        one layer of your own\n"
                           "  vtbuild update area.vts                                    what has changed in its sources since\n"
                           "  vtbuild pack area.vts -o delivery.vts                      without garbage, in streaming order\n");
  return vt::cli::run_main(app, argc, argv, [&]() -> vt::Result<int> {
    for (const auto& command : commands) {
      auto code = command();
      if (!code || *code >= 0) return code;
    }
    return vt::fail(vt::ErrorCode::kInternal, "no subcommand ran");
  });
}
