// vtbench build: whole builds of one image as child processes, ours and other tools' in turn, and the parts that no builder can do without.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "builder/source/raster_source.h"
#include "tools/bench_child.h"
#include "tools/bench_commands.h"
#include "tools/bench_parts.h"
#include "tools/bench_support.h"
#include "tools/bench_svg.h"
#include "tools/cli_support.h"

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

// One program and what it makes of the input.
struct Contender {
  std::string job;      // what is compared: contenders of one job stand side by side
  std::string name;     // for tables and charts
  std::string version;  // as the program says it
  bool is_ours = false;
  JobKind kind;  // of ours
  ChildCommand command;
  std::filesystem::path result;
  bool adds_to_copy = false;  // works on a copy of the input, made beforehand and not counted
};

struct Measured {
  std::vector<double> seconds;
  std::vector<double> sync_seconds;
  double processor_seconds = 0.0;  // of the last run
  std::uint64_t peak_bytes = 0;    // of all runs
  std::uint64_t output_bytes = 0;
};

struct Input {
  std::filesystem::path path;
  source::RasterInfo info;
  std::uint64_t file_bytes = 0;
  double raw_bytes = 0.0;
  [[nodiscard]] double megapixels() const { return static_cast<double>(info.width) * static_cast<double>(info.height) / 1e6; }
};

Result<Input> open_input(const std::string& path) {
  VT_ASSIGN(const auto raster, source::open_raster(path));
  Input input{path, raster->info(), std::filesystem::file_size(path), 0.0};
  input.raw_bytes = input.megapixels() * 1e6 * input.info.bands * static_cast<double>(sample_bytes(input.info.sample_type));
  return input;
}

const std::vector<JobKind>& our_jobs() {
  static const std::vector<JobKind> jobs = {
      {"box", "rgb8", "none"},
      {"kaiser3", "rgb8", "none"},
      {"kaiser3", "bc1", "zstd:3"},
      {"box", "rgb8", "zstd:1"},
  };
  return jobs;
}

std::string job_title(const JobKind& job) {
  return fmt::format("{} filter, {}, {}", job.kernel, job.format, job.compression == "none" ? "uncompressed" : job.compression);
}

Contender our_build(const JobKind& job, const std::filesystem::path& vtbuild, const Input& input, const std::filesystem::path& scratch,
                    int threads) {
  Contender ours;
  ours.job = job_title(job);
  ours.name = "vtbuild";
  ours.is_ours = true;
  ours.kind = job;
  ours.result = scratch / "ours.vts";
  ours.command.arguments = {vtbuild.string(), "layer",         input.path.string(), "-o",        ours.result.string(),
                            "--channel",      "color",         "--kernel",          job.kernel,  "--format",
                            job.format,       "--compression", job.compression,     "--threads", std::to_string(threads),
                            "--progress",     "none"};
  if (!input.info.crs) ours.command.arguments.insert(ours.command.arguments.end(), {"--crs", "pixel"});
  return ours;
}

// libvips: means of 2 x 2 codes, uncompressed.
std::optional<Contender> vips(const JobKind& job, const Input& input, const std::filesystem::path& scratch, int threads) {
  const auto program = find_program("vips");
  if (!program) return std::nullopt;
  Contender peer;
  peer.name = "vips tiffsave --pyramid";
  peer.job = job_title(job);
  peer.result = scratch / "vips.tif";
  peer.command.arguments = {program->string(), "tiffsave",  input.path.string(), peer.result.string(),
                            "--tile",          "--pyramid", "--tile-width",      "256",
                            "--tile-height",   "256"};
  if (input.raw_bytes * 4.0 / 3.0 > 4e9) peer.command.arguments.emplace_back("--bigtiff");
  peer.command.environment = {{"VIPS_CONCURRENCY", std::to_string(threads)}};
  return peer;
}

// GDAL: Lanczos on codes; adds overviews to a file and leaves its finest level alone.
std::optional<Contender> gdaladdo(const JobKind& job, const std::filesystem::path& scratch, int threads) {
  const auto program = find_program("gdaladdo");
  if (!program) return std::nullopt;
  Contender peer;
  peer.name = "gdaladdo -r lanczos";
  peer.job = job_title(job);
  peer.result = scratch / "gdaladdo.tif";
  peer.adds_to_copy = true;
  peer.command.arguments = {program->string(),
                            "-q",
                            "-r",
                            "lanczos",
                            "--config",
                            "GDAL_NUM_THREADS",
                            std::to_string(threads),
                            "--config",
                            "GDAL_TIFF_OVR_BLOCKSIZE",
                            "256",
                            peer.result.string()};
  return peer;
}

// GDAL's cloud-optimised GeoTIFF: means of codes, ZSTD level 1, lossless.
std::optional<Contender> gdal_cog(const JobKind& job, const Input& input, const std::filesystem::path& scratch, int threads) {
  const auto program = find_program("gdal_translate");
  if (!program) return std::nullopt;
  Contender peer;
  peer.name = "gdal_translate -of COG";
  peer.job = job_title(job);
  peer.result = scratch / "cog.tif";
  peer.command.arguments = {program->string(),
                            "-q",
                            "-of",
                            "COG",
                            "-co",
                            "COMPRESS=ZSTD",
                            "-co",
                            "LEVEL=1",
                            "-co",
                            "BLOCKSIZE=256",
                            "-co",
                            "OVERVIEW_RESAMPLING=AVERAGE",
                            "-co",
                            "BIGTIFF=IF_SAFER",
                            "-co",
                            fmt::format("NUM_THREADS={}", threads),
                            "--config",
                            "GDAL_NUM_THREADS",
                            std::to_string(threads),
                            input.path.string(),
                            peer.result.string()};
  return peer;
}

// OpenImageIO: means of codes, uncompressed.
std::optional<Contender> maketx(const JobKind& job, const Input& input, const std::filesystem::path& scratch, int threads) {
  const auto program = find_program("maketx");
  if (!program) return std::nullopt;
  Contender peer;
  peer.name = "maketx --filter box";
  peer.job = job_title(job);
  peer.result = scratch / "maketx.tif";
  peer.command.arguments = {program->string(),
                            "--threads",
                            std::to_string(threads),
                            "--tile",
                            "256",
                            "256",
                            "--compression",
                            "none",
                            "--filter",
                            "box",
                            "-o",
                            peer.result.string(),
                            input.path.string()};
  return peer;
}

std::vector<Contender> all_contenders(const std::filesystem::path& vtbuild, const Input& input, const std::filesystem::path& scratch,
                                      const BenchBuildFlags& flags) {
  std::vector<Contender> all;
  const auto add = [&](std::optional<Contender> peer) {
    if (peer) all.push_back(std::move(*peer));
  };
  for (const JobKind& job : our_jobs()) {
    all.push_back(our_build(job, vtbuild, input, scratch, flags.threads));
    if (flags.peers == "none") continue;
    if (job.format == "rgb8" && job.compression == "none") add(vips(job, input, scratch, flags.threads));
    if (job.kernel == "kaiser3" && job.compression == "none") add(gdaladdo(job, scratch, flags.threads));
    if (job.kernel == "box" && job.compression == "none") add(maketx(job, input, scratch, flags.threads));
    if (job.compression == "zstd:1") add(gdal_cog(job, input, scratch, flags.threads));
  }
  for (Contender& contender : all) contender.command.output = contender.command.errors = scratch / "messages.txt";
  return all;
}

// The first line of `program --version`.
std::string version_of(const Contender& contender, const std::filesystem::path& scratch) {
  ChildCommand command;
  command.arguments = {contender.command.arguments.front(), "--version"};
  command.output = command.errors = scratch / "version.txt";
  const auto run = run_child(command);
  const auto text = read_text_file(command.output);
  return run && run->exit_code == 0 && text ? text->substr(0, text->find('\n')) : "unknown";
}

// Waits until a file is on the disk, so that one contender's unwritten bytes do not slow the next one down.
Result<void> sync_file(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY);
  const bool ok = fd >= 0 && ::fsync(fd) == 0;
  if (fd >= 0) ::close(fd);
  if (!ok) return fail(ErrorCode::kIo, path.string() + ": cannot be synced to the disk");
  return {};
}

Result<void> run_once(const Contender& contender, const Input& input, Measured& measured) {
  std::error_code problem;
  std::filesystem::remove(contender.result, problem);
  if (contender.adds_to_copy) {
    std::filesystem::copy_file(input.path, contender.result, problem);
    if (problem) return fail(ErrorCode::kIo, contender.result.string() + ": cannot copy the input: " + problem.message());
    VT_CHECK(sync_file(contender.result));
  }
  VT_ASSIGN(const ChildRun child, run_child(contender.command));
  VT_CHECK(check_interrupt());
  if (child.exit_code != 0) {
    const auto messages = read_text_file(contender.command.errors);
    return fail(ErrorCode::kIo,
                fmt::format("exit code {} from: {}\n{}", child.exit_code, shell_text(contender.command.arguments), messages.value_or("")));
  }
  Result<void> synced;
  measured.sync_seconds.push_back(seconds_of([&] { synced = sync_file(contender.result); }));
  VT_CHECK(synced);
  measured.seconds.push_back(child.seconds);
  measured.processor_seconds = child.processor_seconds;
  measured.peak_bytes = std::max(measured.peak_bytes, child.peak_bytes);
  measured.output_bytes = std::filesystem::file_size(contender.result) - (contender.adds_to_copy ? input.file_bytes : 0);
  std::filesystem::remove(contender.result, problem);
  return {};
}

// Reads the file once, so that every contender finds it in the page cache.
Result<void> warm_up(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY);
  std::vector<char> buffer(std::size_t{1} << 20);
  ssize_t got = fd < 0 ? -1 : 1;
  while (got > 0) got = ::read(fd, buffer.data(), buffer.size());
  if (fd >= 0) ::close(fd);
  if (got < 0) return fail(ErrorCode::kIo, path.string() + ": cannot be read");
  return {};
}

// Results are removed at once, so the room for the largest one, with a copy of the input, is enough; twice that to be safe.
Result<void> check_room(const std::filesystem::path& scratch, const Input& input) {
  std::error_code problem;
  const auto space = std::filesystem::space(scratch, problem);
  const double wanted = 2.0 * (static_cast<double>(input.file_bytes) + 4.0 / 3.0 * input.raw_bytes);
  if (!problem && static_cast<double>(space.available) < wanted)
    return fail(ErrorCode::kIo, fmt::format("{}: {} are free, {} are wanted; choose another --scratch", scratch.string(),
                                            cli::format_bytes(space.available), cli::format_bytes(static_cast<std::uint64_t>(wanted))));
  return {};
}

// The command as anybody would repeat it: no folders of ours.
std::string public_command(const Contender& contender, const Input& input) {
  std::vector<std::string> arguments = contender.command.arguments;
  arguments.front() = std::filesystem::path(arguments.front()).filename().string();
  for (std::string& argument : arguments) {
    if (argument == contender.result.string()) argument = "OUT";
    if (argument == input.path.string()) argument = "IN";
  }
  std::string text;
  for (const auto& [name, value] : contender.command.environment) text += name + "=" + value + " ";
  return text + shell_text(arguments);
}

Table result_table() {
  return Table({{"job", "job"},
                {"kind", ""},
                {"name", "program or part"},
                {"mpx_per_s", "Mpx/s", 1},
                {"median_s", "median s", 3},
                {"min_s", "min", 3},
                {"max_s", "max", 3},
                {"ours_over_this", "vtbuild is x times", 2},
                {"build_over_parts", "build / parts", 2},
                {"peak_rss_bytes", ""},
                {"peak_mib", "peak MiB", 0},
                {"output_bytes", ""},
                {"output_mib", "output MiB", 1},
                {"cpu_s", "cpu s", 2},
                {"sync_s", "sync s", 3},
                {"version", ""},
                {"command", ""},
                {"runs", ""},
                {"threads", ""},
                {"input_width", ""},
                {"input_height", ""},
                {"input_bands", ""},
                {"input_bytes", ""},
                {"input_compression", ""},
                {"cpu", ""},
                {"cores", ""}});
}

// Cells of `result_table`, by name, so that no figure lands in a neighbour's column.
struct Row {
  std::string job;
  std::string kind;
  std::string name;
  std::optional<Spread> seconds;
  Cell ours_over_this;
  Cell build_over_parts;
  const Measured* measured = nullptr;
  std::string version;
  std::string command;
};

class Report {
 public:
  Report(const Input& input, const BenchBuildFlags& flags) : input_(input), flags_(flags), table_(result_table()) {}

  void add(const Row& row) {
    constexpr double kMib = 1024.0 * 1024.0;
    const auto number = [](bool has, double value) { return has ? Cell(value) : Cell(); };
    const Measured* m = row.measured;
    const Spread s = row.seconds.value_or(Spread{});
    table_.add_row({row.job,
                    row.kind,
                    row.name,
                    number(s.median > 0.0, input_.megapixels() / s.median),
                    number(row.seconds.has_value(), s.median),
                    number(m != nullptr, s.min),
                    number(m != nullptr, s.max),
                    row.ours_over_this,
                    row.build_over_parts,
                    number(m != nullptr, m ? double(m->peak_bytes) : 0.0),
                    number(m != nullptr, m ? double(m->peak_bytes) / kMib : 0.0),
                    number(m != nullptr, m ? double(m->output_bytes) : 0.0),
                    number(m != nullptr, m ? double(m->output_bytes) / kMib : 0.0),
                    number(m != nullptr, m ? m->processor_seconds : 0.0),
                    number(m != nullptr, m ? spread_of(m->sync_seconds).median : 0.0),
                    row.version,
                    row.command,
                    double(flags_.runs),
                    double(flags_.threads),
                    double(input_.info.width),
                    double(input_.info.height),
                    double(input_.info.bands),
                    double(input_.file_bytes),
                    input_.info.compression,
                    machine_.cpu,
                    double(machine_.cores)});
  }
  [[nodiscard]] const Table& table() const { return table_; }

 private:
  const Input& input_;
  const BenchBuildFlags& flags_;
  Machine machine_ = this_machine();
  Table table_;
};

void add_parts(Report& report, const Contender& ours, const PartSeconds& parts, double build_seconds, int threads) {
  const auto add = [&](const char* name, double seconds) {
    if (seconds > 0.0) report.add({.job = ours.job, .kind = "part", .name = name, .seconds = Spread{seconds, seconds, seconds}});
  };
  add("  reading, 1 thread", parts.read);
  add("  filter, 1 thread", parts.filter);
  add("  BC1 encoder, 1 thread", parts.encode);
  add("  zstd, 1 thread", parts.compress);
  add("  writing and sync, 1 thread", parts.write);
  const double share = parts.sum() / threads;
  report.add({.job = ours.job,
              .kind = "parts",
              .name = fmt::format("  sum of parts / {} threads", threads),
              .seconds = Spread{share, share, share},
              .build_over_parts = build_seconds / share});
}

Result<int> run(const BenchBuildFlags& flags) {
  VT_ASSIGN(const std::filesystem::path vtbuild, program_beside("vtbuild"));
  VT_ASSIGN(const Input input, open_input(flags.input));
  if (flags.dry_run) {
    const auto folder =
        flags.scratch.empty() ? std::filesystem::temp_directory_path() / "vtbench-XXXXXX" : std::filesystem::path(flags.scratch);
    for (const Contender& contender : all_contenders(vtbuild, input, folder, flags)) {
      if (contender.adds_to_copy) cli::print(shell_text({"cp", input.path.string(), contender.result.string()}) + "\n");
      std::string line;
      for (const auto& [name, value] : contender.command.environment) line += name + "=" + value + " ";
      cli::print(line + shell_text(contender.command.arguments) + "\n");
    }
    return 0;
  }

  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  VT_CHECK(check_room(scratch.path(), input));
  std::vector<Contender> contenders = all_contenders(vtbuild, input, scratch.path(), flags);
  for (Contender& contender : contenders) contender.version = version_of(contender, scratch.path());
  VT_CHECK(warm_up(input.path));
  const std::uint64_t smallest_peak = smallest_peak_bytes();

  // In turn, so that a slow minute of the machine falls on all of them.
  std::vector<Measured> measured(contenders.size());
  for (int round = 0; round < flags.runs; ++round)
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      VT_CHECK(run_once(contenders[i], input, measured[i]));
      cli::print_note("vtbench", fmt::format("round {} of {}: {}, {}: {:.2f} s", round + 1, flags.runs, contenders[i].job,
                                             contenders[i].name, measured[i].seconds.back()));
    }

  // Only now may our own memory grow: a child's peak is never below its parent's.
  std::optional<PartsBench> parts;
  if (!flags.no_parts) {
    VT_ASSIGN(parts, PartsBench::prepare(input.path, scratch.path(), flags.runs));
  }
  Report report(input, flags);
  BarChart chart;
  chart.title = "Building a pyramid: vtbuild beside other tools";
  chart.axis = "Mpx/s of the finest level, median; longer is better";
  double our_seconds = 0.0;  // contenders of a job follow our own build
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    const Contender& contender = contenders[i];
    const Spread seconds = spread_of(measured[i].seconds);
    if (contender.is_ours) {
      our_seconds = seconds.median;
      chart.groups.push_back({contender.job, {}});
    }
    report.add({.job = contender.job,
                .kind = contender.is_ours ? "ours" : "peer",
                .name = contender.name,
                .seconds = seconds,
                .ours_over_this = contender.is_ours ? Cell() : Cell(seconds.median / our_seconds),
                .measured = &measured[i],
                .version = contender.version,
                .command = public_command(contender, input)});
    chart.groups.back().bars.push_back({contender.name, input.megapixels() / seconds.median, input.megapixels() / seconds.max,
                                        input.megapixels() / seconds.min, contender.is_ours});
    const bool job_ends = i + 1 == contenders.size() || contenders[i + 1].is_ours;
    if (parts && job_ends) {
      const std::size_t ours = static_cast<std::size_t>(
          std::find_if(contenders.begin(), contenders.end(), [&](const Contender& c) { return c.is_ours && c.job == contender.job; }) -
          contenders.begin());
      VT_ASSIGN(const PartSeconds seconds_of_parts, parts->measure(contenders[ours].kind, measured[ours].output_bytes));
      add_parts(report, contenders[ours], seconds_of_parts, our_seconds, flags.threads);
    }
  }
  const std::string subject =
      fmt::format("{} x {}, {} bands of {} bits, {}{}; {} threads; median of {} runs; input in the page cache", input.info.width,
                  input.info.height, input.info.bands, 8 * sample_bytes(input.info.sample_type), input.info.tiled ? "tiled, " : "",
                  input.info.compression == "none" ? "uncompressed" : input.info.compression, flags.threads, flags.runs);
  chart.notes = {
      subject, this_machine().text(),
      "vtbuild filters in linear light and syncs its store to the disk; the other tools filter codes and do not sync. gdaladdo adds "
      "overviews only."};
  VT_CHECK(flags.results.deliver(subject, report.table(), svg_of(chart)));
  if (!flags.results.json)
    cli::print(fmt::format(
        "\nvtbuild's time includes syncing its store to the disk, the other tools' does not: `sync s` is what that takes afterwards.\n"
        "gdaladdo writes overviews only, beside a finest level that is there already.\n"
        "Peaks below {} cannot be told from vtbench's own memory.\n",
        cli::format_bytes(smallest_peak)));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_build_command(CLI::App& app) {
  auto flags = std::make_shared<BenchBuildFlags>();
  CLI::App* command =
      app.add_subcommand("build", "whole builds of one image, ours and other tools' in turn, and the parts that none can avoid");
  command->add_option("INPUT", flags->input, "a colour GeoTIFF")->required();
  command->add_option("--runs", flags->runs, "of each program, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "for every program")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_option("--peers", flags->peers, "auto: vips, GDAL and maketx where they are installed; none: only ours")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_flag("--no-parts", flags->no_parts, "leave out the parts: reading, filter, encoder, zstd, writing, each alone");
  command->add_flag("--dry-run", flags->dry_run, "print the commands and run nothing");
  command->add_option("--scratch", flags->scratch, "folder for what is built (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench build ortho.tif --csv build.csv --svg build.svg\n"
                       "  vtbench build ortho.tif --runs 5 --scratch /fast/disk --peers none\n"
                       "  vtbench build ortho.tif --dry-run\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
