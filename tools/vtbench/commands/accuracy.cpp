// vtbench accuracy: what each kernel, format and compression costs in time and gives in fidelity, beside
// other tools, on one scene that everybody can make.

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "builder/pipeline/build/plan_cost.h"
#include "builder/text/json_text.h"
#include "store/store_reader.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/accuracy_scene.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/svg.h"

namespace vt::bench {
namespace {

struct AccuracyFlags {
  std::int64_t size = 2048;
  int runs = 3;
  int threads = 0;
  std::string compressions = "none,zstd:1,zstd:3,zstd:9,zstd:19";
  std::string peers = "auto";
  std::string scratch;
  ResultFlags results;
};

// One point of the chart. Results stay in the scratch folder until the errors are measured.
struct Variant {
  std::string series;
  std::string label;
  std::string kernel;  // of the exact pyramid to compare with; empty: none is known
  Contender contender;
  Measured measured;
  std::filesystem::path report;  // of vtbuild --json
};

void put_result_at(Contender& contender, const std::filesystem::path& path) {
  for (std::string& argument : contender.command.arguments)
    if (argument == contender.result.string()) argument = path.string();
  contender.result = path;
}

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= list.size();) {
    const std::size_t comma = std::min(list.find(',', at), list.size());
    parts.push_back(list.substr(at, comma - at));
    at = comma + 1;
  }
  return parts;
}

std::vector<Variant> our_variants(const Input& scene, const std::vector<std::string>& compressions, const Setting& setting) {
  std::vector<Variant> variants;
  for (const char* kernel : {"box", "kaiser3"})
    for (const char* format : {"rgb8", "bc1"})
      for (const std::string& compression : compressions) {
        const JobKind job{"color", kernel, format, compression};
        Variant variant{
            fmt::format("{} {}", kernel, format), compression, kernel, our_build(job, scene.path.string(), true, setting), {}, {}};
        variant.report = setting.scratch / fmt::format("report{}.json", variants.size());
        variant.contender.command.output = variant.report;
        variant.contender.command.arguments.emplace_back("--json");
        put_result_at(variant.contender, setting.scratch / fmt::format("variant{}.vts", variants.size()));
        variants.push_back(std::move(variant));
      }
  return variants;
}

std::vector<Variant> peer_variants(const Input& scene, const Setting& setting) {
  const JobKind raw{"color", "box", "rgb8", "none"};
  std::vector<Variant> variants;
  const auto add = [&](const char* label, const char* kernel, std::optional<Contender> contender) {
    if (!contender) return;
    put_result_at(*contender, setting.scratch / fmt::format("peer{}.tif", variants.size()));
    contender->kind = raw;
    variants.push_back({"other tools", label, kernel, std::move(*contender), {}, {}});
  };
  add("gdaladdo average", "box", gdaladdo("average", raw, scene, setting));
  add("gdaladdo lanczos", "", gdaladdo("lanczos", raw, scene, setting));
  add("vips", "box", vips_pyramid(scene, setting));
  return variants;
}

// Bytes of texture a texel, without what the builder keeps for itself.
Result<double> bytes_per_texel(const Variant& variant) {
  VT_ASSIGN(const std::string text, read_text_file(variant.report));
  const auto report = text::json_or_null(text);
  const auto pointer = nlohmann::json::json_pointer("/layers/0/stored_bytes");
  if (!report.is_object() || !report.contains(pointer) || !report[pointer].is_number())
    return fail(ErrorCode::kInvalidData, "vtbuild --json does not say how many bytes it stored; is it of another version?");
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(variant.contender.result));
  return report[pointer].get<double>() / static_cast<double>(pipeline::plan_cost(*reader.find_layer("color")).texels);
}

Table empty_accuracy_table() {
  return Table({{"program", "program"},
                {"kernel", "kernel"},
                {"format", "format"},
                {"compression", "compression"},
                {"mpx_per_s", "Mpx/s", 1},
                {"mpx_per_s_min", "min", 1},
                {"mpx_per_s_max", "max", 1},
                {"psnr_linear_db", "PSNR dB linear", 2},
                {"psnr_code_db", "PSNR dB codes", 2},
                {"kernel_max_dn", "most codes off its kernel", 3},
                {"kernel_psnr_code_db", "PSNR dB codes, its kernel", 2},
                {"base_psnr_code_db", "base dB codes", 2},
                {"luminance_drift_percent", "drift %", 3},
                {"bytes_per_texel", "bytes/texel", 3},
                {"runs", "", 0},
                {"threads", "", 0},
                {"size", "", 0},
                {"cpu", ""},
                {"cores", "", 0}});
}

using NamedCells = std::vector<std::pair<std::string_view, Cell>>;

void append_errors(NamedCells& row, const Errors& errors) {
  row.insert(row.end(), {{"psnr_linear_db", errors.from_ideal.psnr_linear_db()},
                         {"psnr_code_db", errors.from_ideal.psnr_code_db()},
                         {"luminance_drift_percent", errors.from_ideal.worst_drift_percent()}});
  if (errors.from_kernel)
    row.insert(row.end(),
               {{"kernel_max_dn", errors.from_kernel->worst_code_error()}, {"kernel_psnr_code_db", errors.from_kernel->psnr_code_db()}});
}

// Timed before anything large is in memory: forking a large process takes time that would be the child's.
Result<void> run_all(std::vector<Variant>& variants, int runs) {
  for (int run = 0; run <= runs; ++run) {  // the first round is a warm-up
    for (Variant& variant : variants) {
      if (variant.measured.failed) continue;
      Measured ignored;
      if (const auto ran = run_and_keep(variant.contender, run == 0 ? ignored : variant.measured); !ran)
        VT_CHECK(accept_failure(variant.contender, ran.error(), variant.measured));
    }
    cli::print_note("vtbench", run == 0 ? "warm-up done" : fmt::format("round {} of {} done", run, runs));
  }
  return {};
}

Result<int> run(const AccuracyFlags& flags) {
  if (!std::has_single_bit(static_cast<std::uint64_t>(flags.size)) || flags.size < 2 * kSmallestLevel || flags.size > 8192)
    return fail(ErrorCode::kUsage, fmt::format("--size is a power of two from {} to 8192, not {}", 2 * kSmallestLevel, flags.size));
  const std::vector<std::string> compressions = split(flags.compressions);
  for (const std::string& compression : compressions) VT_CHECK(store::parse_compression(compression));
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const Machine machine = this_machine();
  setting.scratch = scratch.path();
  setting.threads = flags.threads > 0 ? flags.threads : machine.cores;
  const auto scene_path = scratch / "scene.tif";
  VT_CHECK(write_scene(scene_path, paint_scene(flags.size), flags.size));
  VT_ASSIGN(const Input scene, open_input(scene_path));
  const auto gdal = find_program("gdal_translate");  // takes the levels out of the peers' files
  std::vector<Variant> variants = our_variants(scene, compressions, setting);
  if (flags.peers != "none" && gdal) {
    for (Variant& peer : peer_variants(scene, setting)) variants.push_back(std::move(peer));
  } else if (flags.peers != "none") {
    cli::print_note("vtbench", "gdal_translate is not installed: other tools are left out");
  }
  VT_CHECK(check_room(scratch.path(), 4.5 * scene.megapixels() * 1e6 * static_cast<double>(variants.size() + 1)));
  VT_CHECK(run_all(variants, flags.runs));

  const Truth truth = make_truth(paint_scene(flags.size), flags.size, {"box", "kaiser3"});
  Table table = empty_accuracy_table();
  const NamedCells setting_cells = {
      {"threads", double(setting.threads)}, {"size", double(flags.size)}, {"cpu", machine.cpu}, {"cores", double(machine.cores)}};
  ScatterChart chart;
  for (const Variant& variant : variants) {
    VT_CHECK(check_interrupt());
    const Contender& contender = variant.contender;
    if (variant.measured.failed) continue;
    VT_ASSIGN(const std::vector<Codes> levels, contender.is_ours
                                                   ? levels_of_store(contender.result, truth.ideal.size())
                                                   : levels_of_tiff(contender.result, truth.ideal.size(), *gdal, scratch.path()));
    const Errors errors = errors_of(levels, truth, variant.kernel);
    const Spread seconds = variant.measured.spread();
    const double speed = scene.megapixels() / seconds.median;
    NamedCells row = {{"program", contender.name},
                      {"kernel", contender.is_ours ? contender.kind.kernel : std::string()},
                      {"format", contender.kind.format},
                      {"compression", contender.kind.compression},
                      {"mpx_per_s", speed},
                      {"mpx_per_s_min", scene.megapixels() / seconds.max},
                      {"mpx_per_s_max", scene.megapixels() / seconds.min},
                      {"base_psnr_code_db", errors.base_psnr_code_db},
                      {"runs", double(flags.runs)}};
    append_errors(row, errors);
    if (contender.is_ours) {
      VT_ASSIGN(const double bytes, bytes_per_texel(variant));
      row.emplace_back("bytes_per_texel", bytes);
    }
    row.insert(row.end(), setting_cells.begin(), setting_cells.end());
    table.add_named_row(row);
    if (chart.series.empty() || chart.series.back().name != variant.series) chart.series.push_back({variant.series, {}});
    chart.series.back().points.push_back({speed, errors.from_ideal.psnr_linear_db(), variant.label});
    chart.series.back().is_joined = contender.is_ours;
  }
  const Errors averaged = errors_of(truth.codes_averaged, truth, "box", 0);
  NamedCells row = {{"program", std::string("by definition")}, {"kernel", std::string("box of codes")}, {"format", std::string("rgb8")}};
  append_errors(row, averaged);
  row.insert(row.end(), setting_cells.begin(), setting_cells.end());
  table.add_named_row(row);

  chart.title = "Overviews: speed against fidelity";
  chart.x_axis = "build speed, Mpx/s of the finest level (logarithmic)";
  chart.y_axis = "PSNR in linear light against ideal overviews, dB";
  chart.log_x = true;
  chart.line = {averaged.from_ideal.psnr_linear_db(), "sRGB codes averaged without going to linear light (no timing)"};
  const std::string subject = fmt::format(
      "Sample scene, {0} x {0} RGB8, {1} threads, median of {2} runs; error over {3} overview levels, read back from what was written",
      flags.size, setting.threads, flags.runs, truth.ideal.size());
  chart.notes = {subject, machine.text(),
                 "Labels: compression. PSNR in linear light: overviews against a 64-tap windowed sinc in double precision."};
  VT_CHECK(flags.results.deliver(
      subject, table, svg_of(chart),
      "PSNR is against ideal overviews: a 64-tap windowed sinc in linear light, double precision.\n"
      "`its kernel` is the same filter by its formula in long double, in linear light; half a code off is what rounding alone costs. For\n"
      "other tools that average, it is the box.\n"));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_accuracy_command(CLI::App& app) {
  auto flags = std::make_shared<AccuracyFlags>();
  CLI::App* command = app.add_subcommand(
      "accuracy", "speed against error for every kernel, format and compression and for other tools, on a built-in scene");
  command->add_option("--size", flags->size, "texels along an edge of the scene, a power of two")->capture_default_str();
  command->add_option("--runs", flags->runs, "builds of each kind after a warm-up, the median counts")
      ->capture_default_str()
      ->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "threads of every program (default: all cores)")->check(CLI::Range(0, 1024));
  command->add_option("--compressions", flags->compressions, "which to try, with commas")->capture_default_str();
  command->add_option("--peers", flags->peers, "auto: gdaladdo and vips where they and gdal_translate are installed; none: only ours")
      ->capture_default_str()
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_option("--scratch", flags->scratch, "folder for the builds (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench accuracy --csv accuracy.csv --svg accuracy.svg\n"
                       "  vtbench accuracy --size 512 --runs 1 --compressions none,zstd:3\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
