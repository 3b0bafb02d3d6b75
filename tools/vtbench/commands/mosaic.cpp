// vtbench mosaic: thousands of small files beside one file with the same texels.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/inputs/pool_image.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/svg.h"

namespace vt::bench {
namespace {

constexpr std::int64_t kMosaicTile = 256;
constexpr std::int64_t kFileTiles = 2;  // along an edge of a file
constexpr std::int64_t kFile = kFileTiles * kMosaicTile;

struct MosaicFlags {
  std::string input;
  std::int64_t files = 10000;
  int runs = 1;
  int threads = 2;
  std::string scratch;
  ResultFlags results;
};

// A rectangle of files, as square as it goes: what does not fill a row is left out.
struct Grid {
  std::int64_t columns = 1;
  std::int64_t rows = 1;
  [[nodiscard]] std::int64_t files() const { return columns * rows; }
  [[nodiscard]] double megapixels() const { return static_cast<double>(files() * kFile * kFile) / 1e6; }
};

Grid grid_of(std::int64_t files) {
  Grid grid;
  grid.columns = std::max<std::int64_t>(static_cast<std::int64_t>(std::sqrt(static_cast<double>(files))), 1);
  grid.rows = files / grid.columns;
  return grid;
}

// Metre texels somewhere in a UTM zone: files know where they lie.
Result<TiledTiffSpec> place_of(std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height) {
  TiledTiffSpec spec{.width = width, .height = height, .tile = kMosaicTile};
  spec.transform = geo::GeoTransform{400000.0 + static_cast<double>(x), 1.0, 0.0, 5600000.0 - static_cast<double>(y), 0.0, -1.0};
  VT_ASSIGN(spec.crs, geo::Crs::from_epsg(32633));
  return spec;
}

// The file whose north-west corner is texel (x, y) of the whole.
Result<void> write_file(const std::filesystem::path& path, const source::RasterSource& whole, std::int64_t x, std::int64_t y,
                        std::vector<std::byte>& tile) {
  constexpr std::array kRgb = {0, 1, 2};
  VT_ASSIGN(const TiledTiffSpec spec, place_of(x, y, kFile, kFile));
  VT_ASSIGN(TiledTiffWriter writer, TiledTiffWriter::create(path, spec));
  for (std::int64_t row = 0; row < kFileTiles; ++row)
    for (std::int64_t column = 0; column < kFileTiles; ++column) {
      VT_CHECK(whole.read({x + column * kMosaicTile, y + row * kMosaicTile, kMosaicTile, kMosaicTile}, kRgb, tile, kMosaicTile * 3));
      VT_CHECK(writer.add_tile(tile));
    }
  return writer.finish(std::array<std::uint32_t, kFileTiles * kFileTiles>{0, 1, 2, 3});
}

Result<void> cut_into_files(const std::filesystem::path& whole_path, const Grid& grid, const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directory(folder, problem);
  if (problem) return fail(ErrorCode::kIo, folder.string() + ": cannot be made: " + problem.message());
  VT_ASSIGN(const auto whole, source::open_raster(whole_path));
  std::vector<std::byte> tile(static_cast<std::size_t>(kMosaicTile * kMosaicTile * 3));
  for (std::int64_t row = 0; row < grid.rows; ++row)
    for (std::int64_t column = 0; column < grid.columns; ++column) {
      VT_CHECK(check_interrupt());
      VT_CHECK(write_file(folder / fmt::format("r{:05}c{:05}.tif", row, column), *whole, column * kFile, row * kFile, tile));
    }
  return {};
}

Result<int> run(const MosaicFlags& flags) {
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  setting.threads = flags.threads;
  VT_ASSIGN(const auto image, source::open_raster(flags.input));
  VT_ASSIGN(const std::uint32_t stored, pool_tiles(image->info()));
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  setting.scratch = scratch.path();
  const std::uint64_t smallest_peak = smallest_peak_bytes();
  const Grid grid = grid_of(flags.files);
  // The files, the stored tiles of the one file, the store.
  VT_CHECK(check_room(scratch.path(), 1.05e6 * grid.megapixels() * (3.0 + 0.67) + kPoolBytes));

  const auto whole = scratch / "whole.tif";
  const auto folder = scratch / "mosaic";
  cli::print_note("vtbench", fmt::format("writing {} files", grid.files()));
  VT_ASSIGN(const TiledTiffSpec spec, place_of(0, 0, grid.columns * kFile, grid.rows * kFile));
  VT_CHECK(write_pool_image(whole, *image, spec));
  VT_CHECK(cut_into_files(whole, grid, folder));
  VT_CHECK(sync_file_system(scratch.path()));
  VT_CHECK(warm_up(whole));
  VT_CHECK(warm_up(folder));

  std::vector<Contender> contenders = {our_build(compact_job(), whole.string(), true, setting),
                                       our_build(compact_job(), folder.string(), true, setting)};
  contenders[0].name = "one file";
  contenders[1].name = fmt::format("{} files of {} x {}", grid.files(), kFile, kFile);
  VT_ASSIGN(const std::vector<Measured> measured, run_in_turn(contenders, flags.runs));

  const Machine machine = this_machine();
  Table table({{"input", "input"},
               {"files", "files", 0},
               {"gigapixels", "Gpx", 2},
               {"mpx_per_s", "Mpx/s", 1},
               {"median_s", "median s", 2},
               {"time_over_one_file", "time / one file's", 3},
               {"peak_rss_bytes", ""},
               {"peak_mib", "peak MiB", 0},
               {"output_bytes", ""},
               {"output_mib", "store MiB", 1},
               {"sync_s", "sync s", 3},
               {"job", ""},
               {"runs", ""},
               {"threads", ""},
               {"cpu", ""},
               {"cores", ""}});
  const std::string subject = fmt::format("{}; {} threads; {} run{} of each; inputs in the page cache", job_title(compact_job()),
                                          flags.threads, flags.runs, flags.runs == 1 ? "" : "s");
  BarChart chart{"A mosaic beside one file with the same texels", "Mpx/s of the finest level, median; longer is better", {}, {}};
  chart.groups.push_back({job_title(compact_job()), {}});
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    const Measured& m = measured[i];
    const Spread seconds = m.spread();
    const auto peak = static_cast<double>(m.peak_bytes);
    const auto output = static_cast<double>(m.output_bytes);
    table.add_named_row({{"input", contenders[i].name},
                         {"files", i == 0 ? 1.0 : double(grid.files())},
                         {"gigapixels", grid.megapixels() * 1e6 / std::pow(2.0, 30)},
                         {"mpx_per_s", grid.megapixels() / seconds.median},
                         {"median_s", seconds.median},
                         {"time_over_one_file", seconds.median / measured[0].spread().median},
                         {"peak_rss_bytes", peak},
                         {"peak_mib", peak / kMib},
                         {"output_bytes", output},
                         {"output_mib", output / kMib},
                         {"sync_s", m.sync_median()},
                         {"job", job_title(compact_job())},
                         {"runs", double(flags.runs)},
                         {"threads", double(flags.threads)},
                         {"cpu", machine.cpu},
                         {"cores", double(machine.cores)}});
    chart.groups.back().bars.push_back(
        {contenders[i].name, grid.megapixels() / seconds.median, grid.megapixels() / seconds.max, grid.megapixels() / seconds.min, true});
  }
  chart.notes = {subject, machine.text()};
  VT_CHECK(flags.results.deliver(
      subject, table, svg_of(chart),
      fmt::format("The one file is a BigTIFF whose table names {} stored tiles, cut from {}, again and again in a pseudo-random order;\n"
                  "every small file is a georeferenced BigTIFF with four tiles of its own. Opening them all is part of the time.\n"
                  "Seconds include syncing the store. Peaks below {} cannot be told from vtbench's own memory.\n",
                  stored, image->info().path.filename().string(), cli::format_bytes(smallest_peak))));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_mosaic_command(CLI::App& app) {
  auto flags = std::make_shared<MosaicFlags>();
  CLI::App* command = app.add_subcommand("mosaic", "a layer of thousands of small files, beside one file with the same texels");
  command->add_option("INPUT", flags->input, "a colour image of 8 bits from which tiles are cut")->required();
  command->add_option("--files", flags->files, "files of 512 x 512 samples; each takes 768 KiB of disk")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000000));
  command->add_option("--runs", flags->runs, "of each, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "of the builder")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_option("--scratch", flags->scratch, "folder for the files and stores (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench mosaic ortho.tif --csv mosaic.csv --svg mosaic.svg\n"
                       "  vtbench mosaic ortho.tif --files 1000 --runs 3\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
