// vtbench sizes: the same job on inputs from a quarter to many gigapixels: does the memory stay, does the
// rate stay?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/inputs/pool_image.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/svg.h"

namespace vt::bench {
namespace {

struct SizesFlags {
  std::string input;
  std::vector<double> gigapixels = {0.25, 1.0, 4.0, 16.0};
  int runs = 1;
  int threads = 2;
  std::string scratch;
  ResultFlags results;
};

// Texels along an edge of a square of 2^30 texels times `gigapixels`, whole tiles of a store and at least
// one.
std::int64_t edge_for(double gigapixels) {
  constexpr std::int64_t kTile = 256;
  return kTile * std::max<std::int64_t>(static_cast<std::int64_t>(std::lround(std::sqrt(gigapixels * std::pow(2.0, 30)) / kTile)), 1);
}

struct Size {
  std::int64_t edge = 0;  // texels
  std::optional<Measured> measured;
  std::string note;
  [[nodiscard]] double megapixels() const { return static_cast<double>(edge) * static_cast<double>(edge) / 1e6; }
  [[nodiscard]] double rate() const { return megapixels() / measured->spread().median; }
};

Result<Size> measure(double gigapixels, const source::RasterSource& image, const SizesFlags& flags, const Setting& setting) {
  Size size;
  size.edge = edge_for(gigapixels);
  VT_ASSIGN(const std::uint32_t stored, pool_tiles(image.info()));
  // BC1 has half a byte a texel, a pyramid 4/3 of its base; zstd and what the carry takes beside stay below
  // that.
  const double wanted = kPoolBytes + 0.5 * 4.0 / 3.0 * size.megapixels() * 1e6 + 64.0 * kMib;
  if (const auto room = check_room(setting.scratch, wanted); !room) {
    cli::print_note("vtbench", fmt::format("{} x {} left out: {}", size.edge, size.edge, room.error().message));
    size.note = "left out: not enough room on the disk";
    return size;
  }

  const auto input = setting.scratch / "input.tif";
  const TiledTiffSpec spec{.width = size.edge, .height = size.edge, .tile = kPoolTile};
  VT_CHECK(write_pool_image(input, image, spec));
  VT_CHECK(sync_file(input));
  const Contender ours = our_build(compact_job(), input.string(), false, setting);
  size.measured.emplace();
  for (int run = 0; run < flags.runs; ++run) {
    VT_CHECK(run_once(ours, *size.measured));
    cli::print_note("vtbench", fmt::format("{0} x {0}: {1:.2f} s", size.edge, size.measured->seconds.back()));
  }
  std::filesystem::remove(input);
  size.note = fmt::format("{} tiles in the file, {} named by its table", stored, spec.columns() * spec.rows());
  return size;
}

Table table_of(const std::vector<Size>& sizes, const SizesFlags& flags) {
  const Machine machine = this_machine();
  Table table({{"kind", ""},
               {"edge", "texels along an edge", 0},
               {"gigapixels", "Gpx", 2},
               {"mpx_per_s", "Mpx/s", 1},
               {"median_s", "median s", 2},
               {"peak_rss_bytes", ""},
               {"peak_mib", "peak MiB", 0},
               {"output_mib", "store MiB", 1},
               {"sync_s", "sync s", 3},
               {"rate_max_over_min", "largest / smallest rate", 3},
               {"note", "note"},
               {"job", ""},
               {"runs", ""},
               {"threads", ""},
               {"cpu", ""},
               {"cores", ""}});
  std::vector<double> rates;
  std::uint64_t most = 0;
  for (const Size& size : sizes) {
    std::vector<std::pair<std::string_view, Cell>> row = {{"kind", std::string("size")},
                                                          {"edge", double(size.edge)},
                                                          {"gigapixels", size.megapixels() * 1e6 / std::pow(2.0, 30)},
                                                          {"note", size.note},
                                                          {"job", job_title(compact_job())},
                                                          {"runs", double(flags.runs)},
                                                          {"threads", double(flags.threads)},
                                                          {"cpu", machine.cpu},
                                                          {"cores", double(machine.cores)}};
    if (size.measured) {
      const auto peak = static_cast<double>(size.measured->peak_bytes);
      row.insert(row.end(), {{"mpx_per_s", size.rate()},
                             {"median_s", size.measured->spread().median},
                             {"peak_rss_bytes", peak},
                             {"peak_mib", peak / kMib},
                             {"output_mib", static_cast<double>(size.measured->output_bytes) / kMib},
                             {"sync_s", size.measured->sync_median()}});
      rates.push_back(size.rate());
      most = std::max(most, size.measured->peak_bytes);
    }
    table.add_named_row(row);
  }
  if (!rates.empty()) {
    const auto [low, high] = std::minmax_element(rates.begin(), rates.end());
    table.add_named_row({{"kind", std::string("flatness")},
                         {"peak_rss_bytes", static_cast<double>(most)},
                         {"peak_mib", static_cast<double>(most) / kMib},
                         {"rate_max_over_min", *high / *low},
                         {"note", std::string("over all sizes: most memory, flatness of the rate")}});
  }
  return table;
}

std::string chart_of(const std::vector<Size>& sizes, const std::string& subject) {
  ScatterChart chart;
  chart.title = "One job from small to large inputs";
  chart.x_axis = "input, gigapixels of 2^30 (logarithmic)";
  chart.y_axis = "Mpx/s of the finest level";
  chart.log_x = true;
  chart.notes = {subject, this_machine().text(), "Labels: peak resident memory."};
  Series series{.name = job_title(compact_job()), .points = {}};
  for (const Size& size : sizes)
    if (size.measured)
      series.points.push_back({size.megapixels() * 1e6 / std::pow(2.0, 30), size.rate(), cli::format_bytes(size.measured->peak_bytes)});
  if (!series.points.empty()) chart.series.push_back(std::move(series));
  return chart.series.empty() ? "" : svg_of(chart);
}

Result<int> run(const SizesFlags& flags) {
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  setting.threads = flags.threads;
  VT_ASSIGN(const auto image, source::open_raster(flags.input));
  VT_ASSIGN(const std::uint32_t stored, pool_tiles(image->info()));
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  setting.scratch = scratch.path();
  const std::uint64_t smallest_peak = smallest_peak_bytes();
  std::vector<Size> sizes;
  for (const double gigapixels : flags.gigapixels) {
    VT_ASSIGN(Size size, measure(gigapixels, *image, flags, setting));
    sizes.push_back(std::move(size));
  }
  const std::string subject = fmt::format("{}; {} threads; {} run{} of each size; input in the page cache", job_title(compact_job()),
                                          flags.threads, flags.runs, flags.runs == 1 ? "" : "s");
  const std::string remarks = fmt::format(
      "Inputs are BigTIFFs of uncompressed 240 x 240 tiles. Their tables name {} stored tiles, cut from {}, again and again in a\n"
      "pseudo-random order, so that neighbours differ: every texel is read and filtered, the disk holds only the stored tiles.\n"
      "A store's tiles are 256 x 256, so they hold pieces of several, and what is stored once there is what the image itself repeats.\n"
      "Seconds include syncing the store. Peaks below {} cannot be told from vtbench's own memory.\n",
      stored, image->info().path.filename().string(), cli::format_bytes(smallest_peak));
  VT_CHECK(flags.results.deliver(subject, table_of(sizes, flags), chart_of(sizes, subject), remarks));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_sizes_command(CLI::App& app) {
  auto flags = std::make_shared<SizesFlags>();
  CLI::App* command = app.add_subcommand("sizes", "peak memory and rate of one job from a quarter to 16 gigapixels");
  command->add_option("INPUT", flags->input, "a colour image of 8 bits from which tiles are cut")->required();
  command->add_option("--gigapixels", flags->gigapixels, "sizes to build, with commas, in 2^30 texels (default: 0.25,1,4,16)")
      ->delimiter(',')
      ->check(CLI::Range(0.0001, 65536.0));
  command->add_option("--runs", flags->runs, "of each size, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "of the builder")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_option("--scratch", flags->scratch, "folder for inputs and stores (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench sizes ortho.tif --csv sizes.csv --svg sizes.svg\n"
                       "  vtbench sizes ortho.tif --gigapixels 0.25,1 --scratch /fast/disk\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
