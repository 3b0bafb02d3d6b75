// vtbench accuracy: what each kernel, format and compression costs in time and gives in fidelity, on one scene that everybody can make.

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <memory>

#include "builder/pipeline/dataset_store.h"
#include "builder/pipeline/layer_build.h"
#include "builder/pipeline/layer_plan.h"
#include "builder/pipeline/plan_cost.h"
#include "builder/sample/bands.h"
#include "builder/source/geotiff_writer.h"
#include "store/bc1.h"
#include "store/region.h"
#include "tools/bench_commands.h"
#include "tools/bench_reference.h"
#include "tools/bench_support.h"
#include "tools/bench_svg.h"
#include "tools/cli_support.h"

namespace vt::bench {
namespace {

struct AccuracyFlags {
  std::int64_t size = 2048;
  int runs = 3;
  int threads = 0;
  std::string compressions = "none,zstd:1,zstd:3,zstd:9,zstd:19";
  std::string scratch;
  ResultFlags results;
};

constexpr std::int64_t kMargin = 8;           // texels; more than the longest kernel of the builder reaches
constexpr std::int64_t kSmallestLevel = 256;  // texels along an edge: the root tile

struct Truth {
  std::vector<std::uint8_t> base;     // codes
  std::vector<LightImage> overviews;  // 0: half the size of the base
  PyramidError codes_averaged;        // of the pyramid that today's tools make
};

std::vector<std::uint8_t> paint_scene(std::int64_t size) {
  const sample::World world(1);
  std::vector<std::uint8_t> rgb;
  sample::Band band;
  for (std::int64_t index = 0; index < sample::band_count(size); ++index) {
    sample::paint_band(world, size, index, band);
    rgb.insert(rgb.end(), band.rgb.begin(), band.rgb.end());
  }
  return rgb;
}

Truth make_truth(std::int64_t size) {
  Truth truth;
  truth.base = paint_scene(size);
  LightImage light = light_from_codes(truth.base, size, size);
  std::vector<std::uint8_t> codes = truth.base;
  for (std::int64_t edge = size / 2; edge >= kSmallestLevel; edge /= 2) {
    light = halve_ideally(light);
    codes = halve_codes(codes, edge * 2, edge * 2);
    truth.codes_averaged.add_level(codes, light, kMargin);
    truth.overviews.push_back(light);
  }
  return truth;
}

Result<void> write_scene(const std::filesystem::path& path, std::span<const std::uint8_t> rgb, std::int64_t size) {
  source::GeoTiffSpec spec;
  spec.width = size;
  spec.height = size;
  spec.bands = 3;
  spec.transform = geo::GeoTransform{500000.0, sample::kTexelMetres, 0.0, 5400000.0, 0.0, -sample::kTexelMetres};
  VT_ASSIGN(spec.crs, geo::Crs::from_epsg(32633));
  VT_ASSIGN(source::GeoTiffWriter writer, source::GeoTiffWriter::create(path, spec));
  VT_CHECK(writer.write_rows(std::as_bytes(rgb), size));
  return writer.finish();
}

struct Variant {
  std::string kernel;
  std::string format;
  std::string compression;
};

struct Built {
  std::uint64_t stored_bytes = 0;
  double seconds = 0.0;
};

// Everything a user waits for: opening the source, planning, building, making the store durable.
Result<Built> build_once(const std::filesystem::path& input, const std::filesystem::path& output, const Variant& variant, int threads) {
  std::filesystem::remove(output);
  Built built;
  Result<void> status;
  built.seconds = seconds_of([&] {
    status = [&]() -> Result<void> {
      pipeline::LayerRequest request;
      request.name = "color";
      request.sources.push_back({.path = input});
      request.format = format_from_name(variant.format);
      request.kernel = variant.kernel;
      request.compression = variant.compression;
      VT_ASSIGN(const pipeline::LayerPlan plan, pipeline::plan_layer(request, std::nullopt, std::size_t{128} << 20));
      VT_ASSIGN(store::StoreWriter writer, pipeline::open_or_create(output, plan.crs, plan.extent()));
      VT_ASSIGN(const pipeline::BuildReport report,
                pipeline::build_layer(writer, plan, {.threads = threads, .cancel = &cli::interrupt_flag()}));
      built.stored_bytes = report.stored_bytes;
      return writer.finish();
    }();
  });
  VT_CHECK(status);
  return built;
}

// One level of the store as RGB codes.
Result<std::vector<std::uint8_t>> level_codes(const store::StoreReader& reader, const LayerInfo& layer, Level level) {
  const TexelRect rect = layer.data_rect(level);
  const auto width = static_cast<std::size_t>(rect.width);
  const auto height = static_cast<std::size_t>(rect.height);
  std::vector<std::byte> payload(payload_bytes(format_info(layer.format), width, height));
  VT_ASSIGN(const store::RegionReport report, store::read_region(reader, layer.id, level, rect, payload));
  if (report.texels_own_level != width * height) return fail(ErrorCode::kInternal, "the store that was just built lacks tiles");
  std::vector<std::uint8_t> rgb(width * height * 3);
  if (layer.format == TexelFormat::kRgb8) {
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = std::to_integer<std::uint8_t>(payload[i]);
    return rgb;
  }
  std::vector<std::byte> rgba(width * height * 4);
  store::decode_bc1_image(payload, width, height, rgba);
  for (std::size_t i = 0; i < width * height; ++i)
    for (std::size_t p = 0; p < 3; ++p) rgb[i * 3 + p] = std::to_integer<std::uint8_t>(rgba[i * 4 + p]);
  return rgb;
}

struct Errors {
  double base_psnr_code_db = 0.0;
  PyramidError overviews;
};

// Read back from the file, so whatever went wrong on the way counts.
Result<Errors> errors_of(const std::filesystem::path& path, const Truth& truth) {
  VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(path));
  const LayerInfo& layer = *reader.find_layer("color");
  Errors errors;
  VT_ASSIGN(const std::vector<std::uint8_t> base, level_codes(reader, layer, layer.finest));
  errors.base_psnr_code_db = psnr_of_codes_db(base, truth.base);
  for (std::size_t k = 0; k < truth.overviews.size(); ++k) {
    const Level level{static_cast<std::uint8_t>(layer.finest.value - 1 - k)};
    VT_ASSIGN(const std::vector<std::uint8_t> codes, level_codes(reader, layer, level));
    errors.overviews.add_level(codes, truth.overviews[k], kMargin);
  }
  return errors;
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

Result<int> run(const AccuracyFlags& flags) {
  if (!std::has_single_bit(static_cast<std::uint64_t>(flags.size)) || flags.size < 2 * kSmallestLevel || flags.size > 8192)
    return fail(ErrorCode::kUsage, fmt::format("--size is a power of two from {} to 8192, not {}", 2 * kSmallestLevel, flags.size));
  const std::vector<std::string> compressions = split(flags.compressions);
  for (const std::string& compression : compressions) VT_CHECK(store::parse_compression(compression));
  warn_about_conditions();
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  const auto input = scratch / "scene.tif";
  const auto output = scratch / "scene.vts";
  const Truth truth = make_truth(flags.size);
  VT_CHECK(write_scene(input, truth.base, flags.size));

  const Machine machine = this_machine();
  const int threads = flags.threads > 0 ? flags.threads : machine.cores;
  const double base_texels = static_cast<double>(flags.size) * static_cast<double>(flags.size);
  Table table({{"kernel", "kernel"},
               {"format", "format"},
               {"compression", "compression"},
               {"mpx_per_s", "Mpx/s", 1},
               {"mpx_per_s_min", "min", 1},
               {"mpx_per_s_max", "max", 1},
               {"psnr_linear_db", "PSNR dB linear", 2},
               {"psnr_code_db", "PSNR dB codes", 2},
               {"base_psnr_code_db", "base dB codes", 2},
               {"luminance_drift_percent", "drift %", 3},
               {"bytes_per_texel", "bytes/texel", 3},
               {"runs", "", 0},
               {"threads", "", 0},
               {"size", "", 0},
               {"cpu", ""},
               {"cores", "", 0}});
  ScatterChart chart;
  chart.title = "Overviews: speed against fidelity";
  chart.x_axis = "build speed, Mpx/s of the finest level (logarithmic)";
  chart.y_axis = "PSNR in linear light against ideal overviews, dB";
  chart.log_x = true;
  for (const char* kernel : {"box", "kaiser3"})
    for (const char* format : {"rgb8", "bc1"}) {
      Series series{.name = fmt::format("{} {}", kernel, format), .points = {}};
      for (const std::string& compression : compressions) {
        const Variant variant{kernel, format, compression};
        std::vector<double> speeds;
        std::uint64_t stored_bytes = 0;
        for (int i = 0; i <= flags.runs; ++i) {  // the first is a warm-up
          VT_CHECK(check_interrupt());
          VT_ASSIGN(const Built built, build_once(input, output, variant, threads));
          if (i > 0) speeds.push_back(base_texels / 1e6 / built.seconds);
          stored_bytes = built.stored_bytes;
        }
        VT_ASSIGN(const Errors errors, errors_of(output, truth));
        const Spread speed = spread_of(speeds);
        VT_ASSIGN(const store::StoreReader reader, store::StoreReader::open(output));
        const double texels = static_cast<double>(pipeline::plan_cost(*reader.find_layer("color")).texels);
        table.add_row({variant.kernel, variant.format, variant.compression, speed.median, speed.min, speed.max,
                       errors.overviews.psnr_linear_db(), errors.overviews.psnr_code_db(), errors.base_psnr_code_db,
                       errors.overviews.worst_drift_percent(), static_cast<double>(stored_bytes) / texels, double(flags.runs),
                       double(threads), double(flags.size), machine.cpu, double(machine.cores)});
        series.points.push_back({speed.median, errors.overviews.psnr_linear_db(), compression});
      }
      chart.series.push_back(std::move(series));
    }
  table.add_row({std::string("box of codes"), std::string("rgb8"), Cell(), Cell(), Cell(), Cell(), truth.codes_averaged.psnr_linear_db(),
                 truth.codes_averaged.psnr_code_db(), Cell(), truth.codes_averaged.worst_drift_percent(), Cell(), Cell(), Cell(),
                 double(flags.size), machine.cpu, double(machine.cores)});
  chart.line = {truth.codes_averaged.psnr_linear_db(), "sRGB codes averaged without going to linear light (no timing)"};

  const std::string subject =
      fmt::format("Sample scene, {0} x {0} RGB8, {1} threads, median of {2} runs; error over {3} overview levels, read back from the store",
                  flags.size, threads, flags.runs, truth.overviews.size());
  chart.notes = {subject, machine.text(),
                 "Labels: compression. PSNR in linear light: overviews against a 64-tap windowed sinc in double precision."};
  VT_CHECK(flags.results.deliver(subject, table, svg_of(chart)));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_accuracy_command(CLI::App& app) {
  auto flags = std::make_shared<AccuracyFlags>();
  CLI::App* command = app.add_subcommand("accuracy", "speed against error for every kernel, format and compression, on a built-in scene");
  command->add_option("--size", flags->size, "texels along an edge of the scene, a power of two")->capture_default_str();
  command->add_option("--runs", flags->runs, "builds of each kind after a warm-up, the median counts")
      ->capture_default_str()
      ->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "threads of the builder (default: all cores)")->check(CLI::Range(0, 1024));
  command->add_option("--compressions", flags->compressions, "which to try, with commas")->capture_default_str();
  command->add_option("--scratch", flags->scratch, "folder for the builds (default: the system's temporary folder)");
  flags->results.add_to(*command, true);
  cli::add_help_footer(*command,
                       "  vtbench accuracy --csv accuracy.csv --svg accuracy.svg\n"
                       "  vtbench accuracy --size 512 --runs 1 --compressions none,zstd:3\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
