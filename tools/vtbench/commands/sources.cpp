// vtbench sources: one job over the same samples in files of all kinds, beside what decoding alone takes.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "builder/source/tiff/geotiff_writer.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"
#include "tools/vtbench/report/svg.h"

namespace vt::bench {
namespace {

struct SourcesFlags {
  std::string input;
  std::int64_t size = 8192;
  int runs = 3;
  int threads = 2;
  std::string scratch;
  ResultFlags results;
};

using Compression = source::GeoTiffSpec::Compression;

// One way to keep the samples.
struct FileKind {
  const char* name;
  const char* file;
  int tile = 0;  // 0: strips
  std::int64_t rows_per_strip = 16;
  Compression compression = Compression::kNone;
  bool is_png = false;
};
constexpr std::int64_t kAllRows = 0;
constexpr std::array<FileKind, 8> kKinds = {{
    {"tiled", "tiled.tif", 256},
    {"striped, 16 rows", "striped.tif"},
    {"one strip", "one-strip.tif", 0, kAllRows},
    {"tiled, deflate", "tiled-deflate.tif", 256, 16, Compression::kDeflate},
    {"striped, deflate", "striped-deflate.tif", 0, 16, Compression::kDeflate},
    {"one strip, deflate", "one-strip-deflate.tif", 0, kAllRows, Compression::kDeflate},
    {"tiled, JPEG", "tiled-jpeg.tif", 256, 16, Compression::kJpeg},
    {"PNG", "samples.png", 0, 16, Compression::kNone, true},
}};

// The middle of `image`, by rows of one tile, so that little is in memory (but libtiff's own buffer of a
// whole strip).
Result<void> write_tiff(const std::filesystem::path& path, const FileKind& kind, const source::RasterSource& image,
                        const source::Window& window) {
  source::GeoTiffSpec spec;
  spec.width = window.width;
  spec.height = window.height;
  spec.bands = 3;
  spec.compression = kind.compression;
  spec.tile = kind.tile;
  spec.rows_per_strip = kind.rows_per_strip == kAllRows ? window.height : kind.rows_per_strip;
  VT_ASSIGN(source::GeoTiffWriter writer, source::GeoTiffWriter::create(path, spec));
  constexpr std::array kRgb = {0, 1, 2};
  constexpr std::int64_t kRows = 256;
  const auto pitch = static_cast<std::size_t>(window.width * 3);
  std::vector<std::byte> rows(pitch * kRows);
  for (std::int64_t y = 0; y < window.height; y += kRows) {
    VT_CHECK(check_interrupt());
    const std::int64_t count = std::min(kRows, window.height - y);
    const auto part = std::span(rows).first(pitch * static_cast<std::size_t>(count));
    VT_CHECK(image.read({window.x, window.y + y, window.width, count}, kRgb, part, pitch));
    VT_CHECK(writer.write_rows(part, count));
  }
  return writer.finish();
}

ChildCommand gdal_translate(const std::filesystem::path& program, const Setting& setting, const std::vector<std::string>& arguments) {
  const auto messages = setting.scratch / "messages.txt";
  ChildCommand command{{program.string(), "-q"}, {}, messages, messages};
  command.arguments.insert(command.arguments.end(), arguments.begin(), arguments.end());
  return command;
}

// Decodes every sample once, into memory, with as many threads as we have; nothing is written.
ChildCommand decode_alone(const std::filesystem::path& program, const std::filesystem::path& file, const Setting& setting) {
  return gdal_translate(program, setting,
                        {"-of", "MEM", "-co", "INTERLEAVE=PIXEL", "--config", "GDAL_NUM_THREADS", std::to_string(setting.threads),
                         file.string(), "in-memory"});
}

struct KindResult {
  const FileKind* kind = nullptr;
  std::uint64_t file_bytes = 0;
  Measured ours;
  std::vector<double> decode_seconds;  // empty without GDAL
};

Result<KindResult> measure(const FileKind& kind, const std::filesystem::path& file, const std::optional<std::filesystem::path>& gdal,
                           const SourcesFlags& flags, const Setting& setting) {
  KindResult result;
  result.kind = &kind;
  result.file_bytes = std::filesystem::file_size(file);
  const Contender ours = our_build(compact_job(), file.string(), false, setting);
  VT_CHECK(warm_up(file));
  for (int run = 0; run < flags.runs; ++run) {
    VT_CHECK(run_once(ours, result.ours));
    if (!gdal) continue;
    const auto decoded = run_checked(decode_alone(*gdal, file, setting));
    if (!decoded && decoded.error().code == ErrorCode::kCancelled) return tl::unexpected(decoded.error());
    if (decoded) result.decode_seconds.push_back(decoded->seconds);
    if (!decoded) cli::print_note("vtbench", decoded.error().message);
  }
  cli::print_note("vtbench", fmt::format("{}: {:.2f} s", kind.name, result.ours.spread().median));
  return result;
}

Table table_of(const std::vector<KindResult>& results, double megapixels, const SourcesFlags& flags, const source::Window& window) {
  const Machine machine = this_machine();
  Table table({{"file", "file"},
               {"mpx_per_s", "Mpx/s", 1},
               {"median_s", "median s", 3},
               {"min_s", "min", 3},
               {"max_s", "max", 3},
               {"peak_rss_bytes", ""},
               {"peak_mib", "peak MiB", 0},
               {"decode_s", "GDAL decodes, s", 3},
               {"build_over_decode", "build / decode", 2},
               {"file_mib", "file MiB", 1},
               {"output_mib", "store MiB", 1},
               {"sync_s", "sync s", 3},
               {"job", ""},
               {"width", ""},
               {"height", ""},
               {"runs", ""},
               {"threads", ""},
               {"cpu", ""},
               {"cores", ""}});
  for (const KindResult& result : results) {
    const Spread seconds = result.ours.spread();
    const auto peak = static_cast<double>(result.ours.peak_bytes);
    const Cell decode = result.decode_seconds.empty() ? Cell() : Cell(spread_of(result.decode_seconds).median);
    const auto* decode_s = std::get_if<double>(&decode);
    table.add_named_row({{"file", std::string(result.kind->name)},
                         {"mpx_per_s", megapixels / seconds.median},
                         {"median_s", seconds.median},
                         {"min_s", seconds.min},
                         {"max_s", seconds.max},
                         {"peak_rss_bytes", peak},
                         {"peak_mib", peak / kMib},
                         {"decode_s", decode},
                         {"build_over_decode", decode_s == nullptr ? Cell() : Cell(seconds.median / *decode_s)},
                         {"file_mib", static_cast<double>(result.file_bytes) / kMib},
                         {"output_mib", static_cast<double>(result.ours.output_bytes) / kMib},
                         {"sync_s", result.ours.sync_median()},
                         {"job", job_title(compact_job())},
                         {"width", double(window.width)},
                         {"height", double(window.height)},
                         {"runs", double(flags.runs)},
                         {"threads", double(flags.threads)},
                         {"cpu", machine.cpu},
                         {"cores", double(machine.cores)}});
  }
  return table;
}

BarChart chart_of(const std::vector<KindResult>& results, double megapixels, const std::string& subject) {
  BarChart chart{"The same samples in files of all kinds", "Mpx/s, median; longer is better", {subject, this_machine().text()}, {}};
  for (const KindResult& result : results) {
    BarGroup group{result.kind->name, {}};
    const Spread seconds = result.ours.spread();
    group.bars.push_back({"vtbuild", megapixels / seconds.median, megapixels / seconds.max, megapixels / seconds.min, true});
    if (!result.decode_seconds.empty()) {
      const Spread decode = spread_of(result.decode_seconds);
      group.bars.push_back({"GDAL, decoding alone", megapixels / decode.median, megapixels / decode.max, megapixels / decode.min, false});
    }
    chart.groups.push_back(std::move(group));
  }
  return chart;
}

Result<int> run(const SourcesFlags& flags) {
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  setting.threads = flags.threads;
  VT_ASSIGN(const auto image, source::open_raster(flags.input));
  const source::RasterInfo& info = image->info();
  if (info.bands < 3 || info.sample_type != SampleType::kUint8)
    return fail(ErrorCode::kUsage, flags.input + ": the files are made from three bands of 8 bits, and this has others");
  source::Window window;
  window.width = std::min(flags.size, info.width);
  window.height = std::min(flags.size, info.height);
  window.x = (info.width - window.width) / 2;
  window.y = (info.height - window.height) / 2;
  const double megapixels = static_cast<double>(window.width) * static_cast<double>(window.height) / 1e6;
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  setting.scratch = scratch.path();
  VT_CHECK(check_room(scratch.path(), 16.0e6 * megapixels));  // two files, the store, samples that a build keeps beside it
  const std::uint64_t smallest_peak = smallest_peak_bytes();
  const auto gdal = find_program("gdal_translate");
  if (!gdal) cli::print_note("vtbench", "gdal_translate is not installed: no PNG is made, and decoding alone is not measured");

  std::vector<KindResult> results;
  const auto tiled = scratch / kKinds.front().file;  // kept to make the PNG from
  for (const FileKind& kind : kKinds) {
    const auto file = scratch / kind.file;
    if (kind.is_png && !gdal) continue;
    if (kind.is_png) {
      VT_CHECK(run_checked(gdal_translate(*gdal, setting, {"-of", "PNG", tiled.string(), file.string()})));
      VT_CHECK(sync_file(file));
    } else {
      VT_CHECK(write_tiff(file, kind, *image, window));
    }
    VT_ASSIGN(KindResult result, measure(kind, file, gdal, flags, setting));
    results.push_back(std::move(result));
    if (file != tiled) std::filesystem::remove(file);
  }

  const std::string subject =
      fmt::format("{}; the middle {} x {} samples of {}; {} threads; median of {} runs; input in the page cache", job_title(compact_job()),
                  window.width, window.height, info.path.filename().string(), flags.threads, flags.runs);
  const std::string remarks = fmt::format(
      "TIFFs are written by this project's writer over libtiff (deflate with a horizontal predictor, JPEG at libtiff's quality of 75), the "
      "PNG by gdal_translate.\n"
      "Decoding alone is `gdal_translate -of MEM -co INTERLEAVE=PIXEL` with GDAL_NUM_THREADS={}: every sample is decoded once, into "
      "memory.\n"
      "Seconds of builds include syncing the store. Peaks below {} cannot be told from vtbench's own memory.\n",
      flags.threads, cli::format_bytes(smallest_peak));
  VT_CHECK(flags.results.deliver(subject, table_of(results, megapixels, flags, window), svg_of(chart_of(results, megapixels, subject)),
                                 remarks));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_sources_command(CLI::App& app) {
  auto flags = std::make_shared<SourcesFlags>();
  CLI::App* command = app.add_subcommand("sources", "one job over the same samples in tiled, striped and compressed TIFFs and in a PNG");
  command->add_option("INPUT", flags->input, "a colour image of 8 bits")->required();
  command->add_option("--size", flags->size, "samples along an edge of the middle part that is used")
      ->capture_default_str()
      ->check(CLI::Range(16, 16384));
  command->add_option("--runs", flags->runs, "of each file, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "of builder and decoder")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_option("--scratch", flags->scratch, "folder for files and stores (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench sources ortho.tif --csv sources.csv --svg sources.svg\n"
                       "  vtbench sources ortho.tif --size 4096 --runs 1\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
