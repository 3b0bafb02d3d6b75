// vtbench build: whole builds of one raster as child processes, ours and other tools' in turn, and the parts
// that no builder can do without.

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/measure/parts.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/build_report.h"

namespace vt::bench {
namespace {

struct BenchBuildFlags {
  std::string input;
  int runs = 3;
  int threads = 2;
  std::string scratch;
  std::string peers = "auto";
  bool no_parts = false;
  bool dry_run = false;
  ResultFlags results;
};

void print_commands(const Input& input, const Setting& setting) {
  for (const Contender& contender : contenders_for(input, setting)) {
    if (contender.starts_from) cli::print(shell_text({"cp", contender.starts_from->string(), contender.result.string()}) + "\n");
    cli::print(full_command(contender) + "\n");
  }
}

Result<int> run(const BenchBuildFlags& flags) {
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  setting.threads = flags.threads;
  setting.with_peers = flags.peers != "none";
  VT_ASSIGN(const Input input, open_input(flags.input));
  if (flags.dry_run) {
    setting.scratch =
        flags.scratch.empty() ? std::filesystem::temp_directory_path() / "vtbench-XXXXXX" : std::filesystem::path(flags.scratch);
    print_commands(input, setting);
    return 0;
  }

  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  setting.scratch = scratch.path();
  // Results are removed at once, so the room for the largest one, with a copy of the input, is enough; twice
  // that to be safe.
  VT_CHECK(check_room(scratch.path(), 2.0 * (static_cast<double>(input.file_bytes) + 4.0 / 3.0 * input.raw_bytes)));
  std::vector<Contender> contenders = contenders_for(input, setting);
  for (Contender& contender : contenders) contender.version = version_of(contender, scratch.path());
  VT_CHECK(warm_up(input.path));
  const std::uint64_t smallest_peak = smallest_peak_bytes();
  VT_ASSIGN(const std::vector<Measured> measured, run_in_turn(contenders, flags.runs));

  // Only now may our own memory grow: a child's peak is never below its parent's.
  std::optional<PartsBench> parts;
  if (!flags.no_parts) {
    VT_ASSIGN(parts, PartsBench::prepare(input.path, scratch.path(), flags.runs));
  }
  BuildReport report(input, flags.threads);
  std::size_t ours = 0;  // the build that the contenders around belong to
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    if (contenders[i].is_ours) ours = i;
    if (!measured[i].failed) report.add(contenders[i], measured[i]);
    const bool job_ends = i + 1 == contenders.size() || contenders[i + 1].is_ours;
    if (!parts || !job_ends) continue;
    VT_ASSIGN(const PartSeconds seconds, parts->measure(contenders[ours].kind, measured[ours].output_bytes));
    report.add_parts(seconds);
  }
  const std::string subject =
      fmt::format("{}; {} threads; median of {} runs; input in the page cache", input.text(), flags.threads, flags.runs);
  const std::string remarks = fmt::format(
      "vtbuild's time includes syncing its store to the disk, the other tools' does not: `sync s` is what that takes afterwards.\n"
      "Parts run one after the other on one thread, each by the code of a build; their sum is without and with the sync of the store's\n"
      "bytes, of which a build can do some while it computes.\n"
      "vtbuild also hashes its samples and its records; `hashing` says what that takes, the sum of parts is without it.\n"
      "gdaladdo writes overviews only, beside a finest level that is there already and stays as it is.\n"
      "A peer ten times slower than vtbuild runs once.\n"
      "Peaks below {} cannot be told from vtbench's own memory.\n",
      cli::format_bytes(smallest_peak));
  VT_CHECK(flags.results.deliver(subject, report.table(), svg_of(report.chart(subject)), remarks));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_build_command(CLI::App& app) {
  auto flags = std::make_shared<BenchBuildFlags>();
  CLI::App* command =
      app.add_subcommand("build", "whole builds of one raster, ours and other tools' in turn, and the parts that none can avoid");
  command->add_option("INPUT", flags->input, "a colour GeoTIFF, or heights: one band of floats or 16 bit integers")->required();
  command->add_option("--runs", flags->runs, "of each program, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "for every program")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_option("--peers", flags->peers, "auto: vips, GDAL and maketx where they are installed; none: only ours")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_flag("--no-parts", flags->no_parts, "leave out the parts: reading, filter, encoder, compression, writing, each alone");
  command->add_flag("--dry-run", flags->dry_run, "print the commands and run nothing");
  command->add_option("--scratch", flags->scratch, "folder for what is built (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench build ortho.tif --csv build.csv --svg build.svg\n"
                       "  vtbench build dem.tif --runs 5 --scratch /fast/disk --peers none\n"
                       "  vtbench build ortho.tif --dry-run\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
