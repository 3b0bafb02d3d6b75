#include "tools/vtbench/peers/contenders.h"

#include <fmt/format.h>

namespace vt::bench {
namespace {

using Arguments = std::vector<std::string>;

std::string environment_text(const Contender& contender) {
  std::string text;
  for (const auto& [name, value] : contender.command.environment) text += name + "=" + value + " ";
  return text;
}

std::optional<Contender> peer(const std::string& program, const std::string& name, const std::string& file, const Setting& setting) {
  const auto path = find_program(program);
  if (!path) return std::nullopt;
  Contender contender;
  contender.name = name;
  contender.result = setting.scratch / file;
  contender.command.arguments = {path->string()};
  contender.command.output = contender.command.errors = setting.scratch / "messages.txt";
  return contender;
}

void append(Contender& contender, const Arguments& arguments) {
  contender.command.arguments.insert(contender.command.arguments.end(), arguments.begin(), arguments.end());
}

// GDAL's cloud-optimised GeoTIFF: means of codes, ZSTD level 1, lossless.
std::optional<Contender> gdal_cog(const Input& input, const Setting& setting, bool predicts) {
  auto cog = peer("gdal_translate", predicts ? "gdal_translate -of COG, predictor" : "gdal_translate -of COG", "cog.tif", setting);
  if (!cog) return cog;
  append(*cog, {"-q", "-of", "COG", "-co", "COMPRESS=ZSTD", "-co", "LEVEL=1", "-co", "BLOCKSIZE=256", "-co", "OVERVIEW_RESAMPLING=AVERAGE",
                "-co", "BIGTIFF=IF_SAFER"});
  if (predicts) append(*cog, {"-co", "PREDICTOR=YES"});
  append(*cog, {"-co", fmt::format("NUM_THREADS={}", setting.threads), "--config", "GDAL_NUM_THREADS", std::to_string(setting.threads),
                input.path.string(), cog->result.string()});
  return cog;
}

// OpenImageIO: means of codes, uncompressed.
std::optional<Contender> maketx(const Input& input, const Setting& setting) {
  auto tx = peer("maketx", "maketx --filter box", "maketx.tif", setting);
  if (!tx) return tx;
  append(*tx, {"--threads", std::to_string(setting.threads), "--tile", "256", "256", "--compression", "none", "--filter", "box", "-o",
               tx->result.string(), input.path.string()});
  return tx;
}

std::vector<std::optional<Contender>> peers_of(const JobKind& job, const Input& input, const Setting& setting) {
  const bool raw = job.compression == "none";
  if (job.channel == "elevation") {
    if (raw) return {gdaladdo("average", job, input, setting)};
    return {gdaladdo("average", job, input, setting), gdal_cog(input, setting, true)};
  }
  if (job.format != "rgb8") return {};
  if (!raw) return {gdal_cog(input, setting, false), gdal_cog(input, setting, true)};
  if (job.kernel == "kaiser3") return {vips_pyramid(input, setting), gdaladdo("lanczos", job, input, setting)};
  return {vips_pyramid(input, setting), maketx(input, setting)};
}

}  // namespace

std::string Input::text() const {
  return fmt::format("{} x {}, {} band{} of {} bits, {}{}", info.width, info.height, info.bands, info.bands == 1 ? "" : "s",
                     8 * sample_bytes(info.sample_type), info.tiled ? "tiled, " : "",
                     info.compression == "none" ? "uncompressed" : info.compression);
}

Result<Input> open_input(const std::filesystem::path& path) {
  VT_ASSIGN(const auto raster, source::open_raster(path));
  Input input{path, raster->info(), std::filesystem::file_size(path), 0.0};
  input.raw_bytes = input.megapixels() * 1e6 * input.info.bands * static_cast<double>(sample_bytes(input.info.sample_type));
  return input;
}

std::vector<JobKind> jobs_for(const source::RasterInfo& info) {
  const bool is_height = info.bands == 1 && (info.sample_type == SampleType::kFloat32 || info.sample_type == SampleType::kFloat64 ||
                                             info.sample_type == SampleType::kInt16);
  if (is_height) return {{"elevation", "box", "r32f", "none"}, {"elevation", "box", "r32f", "zstd:1"}};
  return {{"color", "box", "rgb8", "none"},
          {"color", "kaiser3", "rgb8", "none"},
          {"color", "kaiser3", "bc1", "zstd:3"},
          {"color", "box", "rgb8", "zstd:1"}};
}

const JobKind& compact_job() {
  static const JobKind job = {"color", "kaiser3", "bc1", "zstd:3"};
  return job;
}

std::string job_title(const JobKind& job) {
  return fmt::format("{}{} filter, {}, {}", job.channel == "color" ? "" : job.channel + ", ", job.kernel, job.format,
                     job.compression == "none" ? "uncompressed" : job.compression);
}

Contender our_build(const JobKind& job, const std::string& input, bool is_placed, const Setting& setting) {
  Contender ours;
  ours.job = job_title(job);
  ours.name = "vtbuild";
  ours.is_ours = true;
  ours.kind = job;
  ours.result = setting.scratch / "ours.vts";
  ours.command.arguments = {setting.vtbuild.string(),
                            "layer",
                            input,
                            "-o",
                            ours.result.string(),
                            "--channel",
                            job.channel,
                            "--kernel",
                            job.kernel,
                            "--format",
                            job.format,
                            "--compression",
                            job.compression,
                            "--threads",
                            std::to_string(setting.threads),
                            "--progress",
                            "none"};
  if (!is_placed) append(ours, {"--crs", "pixel"});
  ours.command.output = ours.command.errors = setting.scratch / "messages.txt";
  return ours;
}

// libvips: means of 2 x 2 codes, uncompressed.
std::optional<Contender> vips_pyramid(const Input& input, const Setting& setting) {
  auto vips = peer("vips", "vips tiffsave --pyramid", "vips.tif", setting);
  if (!vips) return vips;
  append(*vips,
         {"tiffsave", input.path.string(), vips->result.string(), "--tile", "--pyramid", "--tile-width", "256", "--tile-height", "256"});
  if (input.raw_bytes * 4.0 / 3.0 > 4e9) append(*vips, {"--bigtiff"});
  vips->command.environment = {{"VIPS_CONCURRENCY", std::to_string(setting.threads)}};
  return vips;
}

// GDAL: filters codes; adds overviews to a file and leaves its finest level alone, as it is and as it is
// compressed.
std::optional<Contender> gdaladdo(const std::string& resampling, const JobKind& job, const Input& input, const Setting& setting) {
  auto addo = peer("gdaladdo", "gdaladdo -r " + resampling, "gdaladdo.tif", setting);
  if (!addo) return addo;
  addo->starts_from = input.path;
  append(*addo, {"-q", "-r", resampling, "--config", "GDAL_NUM_THREADS", std::to_string(setting.threads), "--config",
                 "GDAL_TIFF_OVR_BLOCKSIZE", "256"});
  if (job.compression.starts_with("zstd:"))
    append(*addo, {"--config", "COMPRESS_OVERVIEW", "ZSTD", "--config", "ZSTD_LEVEL_OVERVIEW", job.compression.substr(5), "--config",
                   "PREDICTOR_OVERVIEW", job.channel == "elevation" ? "3" : "2"});
  append(*addo, {addo->result.string()});
  return addo;
}

std::vector<Contender> contenders_for(const Input& input, const Setting& setting) {
  std::vector<Contender> all;
  for (const JobKind& job : jobs_for(input.info)) {
    all.push_back(our_build(job, input.path.string(), input.info.crs.has_value(), setting));
    if (!setting.with_peers) continue;
    for (std::optional<Contender>& found : peers_of(job, input, setting)) {
      if (!found) continue;
      found->job = job_title(job);
      all.push_back(std::move(*found));
    }
  }
  return all;
}

std::string public_command(const Contender& contender, const std::string& input) {
  Arguments arguments = contender.command.arguments;
  arguments.front() = std::filesystem::path(arguments.front()).filename().string();
  for (std::string& argument : arguments) {
    if (argument == contender.result.string()) argument = "OUT";
    if (argument == input) argument = "IN";
  }
  return environment_text(contender) + shell_text(arguments);
}

std::string full_command(const Contender& contender) { return environment_text(contender) + shell_text(contender.command.arguments); }

}  // namespace vt::bench
