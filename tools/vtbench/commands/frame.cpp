// vtbench frame: frame times of a flight, from the vtrender that lies beside.

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "builder/text/json_text.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/child_process.h"

namespace vt::bench {
namespace {

struct FrameFlags {
  std::string store;
  std::vector<std::string> paths = {"gl12", "glsl"};
  int frames = 300;
  std::string size = "1280x720";
  double speed_m_s = 0.0;
  double rate_hz = 60.0;
  int texture_mib = 64;
  std::string scratch;
  ResultFlags results;
};

// "12, 11, 10 (4)": of levels that are not seen in every frame, in how many they are.
std::string levels_text(const nlohmann::ordered_json& frames) {
  std::string text;
  if (!frames.contains("levels") || !frames["levels"].is_array()) return text;
  for (auto level = frames["levels"].rbegin(); level != frames["levels"].rend(); ++level) {
    text += (text.empty() ? "" : ", ") + (*level)["level"].dump();
    if ((*level)["frames"] != frames["count"]) text += " (" + (*level)["frames"].dump() + ")";
  }
  return text;
}

Result<int> run(const FrameFlags& flags) {
  VT_ASSIGN(const std::filesystem::path vtrender, program_beside("vtrender"));
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const Machine machine = this_machine();
  // What vtrender reports about the frames, and how we show it.
  const std::vector<Column> figures = {{"median_ms", "median ms", 2},
                                       {"p99_ms", "99 % ms", 2},
                                       {"max_ms", "max ms", 2},
                                       {"own_median_ms", "own median ms", 3},
                                       {"own_p99_ms", "own 99 % ms", 3},
                                       {"update_median_ms", "update median ms", 3},
                                       {"select_bind_median_ms", "select, bind median ms", 3},
                                       {"mean_patches", "patches a frame", 1},
                                       {"mean_tiles", "tiles a frame", 1},
                                       {"mean_binds", "binds a frame", 1},
                                       {"pages", "tiles uploaded", 0},
                                       {"uploading", "frames with uploads", 0},
                                       {"upload_bytes", "bytes", 0},
                                       {"upload_most_bytes", "most bytes a frame", 0},
                                       {"upload_budget_bytes", "budget", 0}};
  std::vector<Column> columns = {{"path", "path"}, {"count", "frames", 0}, {"loaded", "with all tiles", 0}, {"levels", "levels seen"}};
  columns.insert(columns.end(), figures.begin(), figures.end());
  columns.insert(columns.end(), {{"window", ""}, {"cpu", ""}, {"cores", "", 0}});
  Table table(columns);
  for (const std::string& path : flags.paths) {
    VT_CHECK(check_interrupt());
    ChildCommand command;
    command.arguments = {vtrender.string(),
                         flags.store,
                         "--path",
                         path,
                         "--size",
                         flags.size,
                         "--frames",
                         std::to_string(flags.frames),
                         "--fly",
                         "--json",
                         "--rate",
                         cli::format_exact(flags.rate_hz),
                         "--texture-memory",
                         std::to_string(flags.texture_mib)};
    if (flags.speed_m_s > 0.0) command.arguments.insert(command.arguments.end(), {"--speed", cli::format_exact(flags.speed_m_s)});
    command.output = scratch / "report.json";
    command.errors = scratch / "errors.txt";
    VT_ASSIGN(const ChildRun child, run_child(command));
    VT_ASSIGN(const std::string errors, read_text_file(command.errors));
    if (child.exit_code != 0)
      return fail(ErrorCode::kIo, fmt::format("{}: exit code {}\n{}", shell_text(command.arguments), child.exit_code, errors));
    VT_ASSIGN(const std::string text, read_text_file(command.output));
    const auto report = text::json_or_null(text);
    if (!report.is_object() || !report.contains("frames") || !report["frames"].is_object())
      return fail(ErrorCode::kInvalidData, vtrender.string() + ": its report has no \"frames\"; is it of another version?");
    const auto figure = [&](const std::string& key) -> Cell {
      const auto& frames = report["frames"];
      return frames.contains(key) && frames[key].is_number() ? Cell(frames[key].get<double>()) : Cell();
    };
    std::vector<Cell> row = {path, figure("count"), figure("loaded"), levels_text(report["frames"])};
    for (const Column& column : figures) row.push_back(figure(column.key));
    row.insert(row.end(), {flags.size, machine.cpu, double(machine.cores)});
    table.add_row(std::move(row));
  }
  VT_CHECK(flags.results.deliver(
      fmt::format("A low flight over {}, window {}, {} MiB of textures, at most {:g} frames a second; `own` is the virtual texture's part "
                  "of a frame: "
                  "update with its uploads, selection and binding",
                  std::filesystem::path(flags.store).filename().string(), flags.size, flags.texture_mib, flags.rate_hz),
      table, ""));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_frame_command(CLI::App& app) {
  auto flags = std::make_shared<FrameFlags>();
  CLI::App* command = app.add_subcommand("frame", "frame times of a flight over a store, by running vtrender");
  command->add_option("STORE", flags->store, "the store to fly over")->required();
  command->add_option("--path", flags->paths, "gl12 or glsl; may be given twice (default: both)")->check(CLI::IsMember({"gl12", "glsl"}));
  command->add_option("--frames", flags->frames, "frames to draw")->capture_default_str()->check(CLI::Range(1, 1000000));
  command->add_option("--size", flags->size, "pixels of the window")->capture_default_str();
  command->add_option("--speed", flags->speed_m_s, "metres a second at 60 frames a second (default: half the area in all)");
  command->add_option("--rate", flags->rate_hz, "frames a second at most")->capture_default_str()->check(CLI::Range(0.1, 1000.0));
  command
      ->add_option("--texture-memory", flags->texture_mib,
                   "MiB of textures; less than the layer takes, so that the flight has something to upload")
      ->capture_default_str()
      ->check(CLI::Range(1, 16384));
  command->add_option("--scratch", flags->scratch, "folder for reports (default: the system's temporary folder)");
  flags->results.add_to(*command, false);
  cli::add_help_footer(*command,
                       "  vtbench frame area.vts\n  vtbench frame area.vts --path glsl --frames 600 --speed 1020 --csv frame.csv\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
