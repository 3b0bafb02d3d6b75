// vtbuild sample: a procedural scene to try everything with.

#include <fmt/format.h>

#include <memory>

#include "builder/sample/sample_scene.h"
#include "tools/vtbuild/build_flags.h"

namespace vt::tools {

std::function<Result<int>()> add_sample_command(CLI::App& app) {
  struct SampleFlags {
    std::string folder;
    std::int64_t size = 4096;
    std::uint64_t seed = 1;
    bool force = false;
    std::string progress = "auto";
  };
  auto flags = std::make_shared<SampleFlags>();
  CLI::App* command =
      app.add_subcommand("sample", "write a procedural scene whose layers fit together: imagery, elevation, materials, lights, SCENE.json");
  command->add_option("-o,--output", flags->folder, "folder to write into")->required();
  command->add_option("--size", flags->size, "texels along an edge of the imagery")
      ->capture_default_str()
      ->check(CLI::Range(sample::kMinSampleSize, sample::kMaxSampleSize));
  command->add_option("--seed", flags->seed, "another number, another country")->capture_default_str();
  command->add_flag("--force", flags->force, "replace files of the same names that are not those of a sample scene as well");
  command->add_option("--progress", flags->progress, "auto, plain or none")->capture_default_str();
  cli::add_help_footer(*command, "  vtbuild sample -o sample && vtbuild dataset sample/SCENE.json -o sample.vts\n");
  return [flags, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    VT_ASSIGN(const cli::ProgressMode mode, cli::progress_mode_from_name(flags->progress));
    constexpr std::uint64_t kSteps = 1000;
    cli::Progress progress({.mode = mode, .title = "sample scene", .unit = "permille", .total = kSteps});
    sample::SampleOptions options;
    options.size = flags->size;
    options.seed = flags->seed;
    options.replace_anything = flags->force;
    options.progress = [&](double fraction) {
      progress.update(static_cast<std::uint64_t>(fraction * kSteps));
      return !cli::interrupt_flag();
    };
    VT_CHECK(sample::write_sample_scene(flags->folder, options));
    progress.finish();
    cli::print(fmt::format("{}/SCENE.json: {} x {} texels, seed {}\n", flags->folder, flags->size, flags->size, flags->seed));
    return 0;
  };
}

}  // namespace vt::tools
