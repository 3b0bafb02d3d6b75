// vtbench channels: how fast each channel type is built in each of its formats, on rasters made for it,
// beside gdaladdo on the same raster.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>

#include "builder/source/tiff/geotiff_writer.h"
#include "tools/cli/cli_support.h"
#include "tools/vtbench/commands.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/measure/whole_builds.h"
#include "tools/vtbench/peers/contenders.h"

namespace vt::bench {
namespace {

struct ChannelsFlags {
  std::int64_t size = 4096;
  int runs = 3;
  int threads = 2;
  std::string only;
  std::string scratch;
  bool only_ours = false;
  ResultFlags results;
};

// One kind of input and what is built from it.
struct ChannelJob {
  std::string channel;
  int bands = 1;
  SampleType type = SampleType::kUint8;
  std::function<double(double x, double y, int band)> value;  // of a place from 0 to 1
  std::string peer_resampling;                                // of gdaladdo
  std::vector<std::string> formats;
  std::vector<std::string> options;  // of every build
};

// Hills of several sizes, -1 to 1, with a little of what no predictor foretells.
double hills(double x, double y) {
  double sum = 0.0;
  double weight = 0.5;
  for (const double f : {9.0, 37.0, 151.0, 1283.0}) {
    sum += weight * std::sin(f * x + 3.0 * std::sin(0.7 * f * y)) * std::cos(1.3 * f * y + std::sin(f * x));
    weight *= 0.5;
  }
  return sum;
}

std::vector<ChannelJob> channel_jobs() {
  const auto normal = [](double x, double y, int band) {
    const double east = 0.5 * hills(x, y);
    const double north = 0.5 * hills(y, x);
    const double length = std::sqrt(east * east + north * north + 1.0);
    return std::round(128.0 + 127.0 * (band == 0 ? east : band == 1 ? north : 1.0) / length);
  };
  const auto height = [](double x, double y, int) { return 900.0 + 800.0 * hills(x, y); };
  return {
      {"color",
       3,
       SampleType::kUint8,
       [](double x, double y, int band) { return 128.0 + 120.0 * hills(x + 0.1 * band, y); },
       "average",
       {"rgb8", "bc1", "bc3", "bc7"},
       {}},
      {"normal", 3, SampleType::kUint8, normal, "average", {"rgb8", "rg16", "bc5"}, {}},
      {"horizon",
       2,
       SampleType::kFloat32,
       [](double x, double y, int band) { return 0.2 + 0.2 * hills(x + 0.1 * band, y); },
       "average",
       {"rgba16", "bc5"},
       {}},
      {"elevation", 1, SampleType::kFloat32, height, "average", {"r32f", "r16f"}, {}},
      {"elevation", 1, SampleType::kFloat32, height, "average", {"r16"}, {"--range", "0,1800"}},
      {"material",
       1,
       SampleType::kUint8,
       [](double x, double y, int) { return std::floor(6.0 + 5.0 * hills(x, y)); },
       "mode",
       {"r8", "r16"},
       {}},
      {"sensor",
       1,
       SampleType::kFloat32,
       [](double x, double y, int) { return 30.0 + 10.0 * hills(x, y); },
       "average",
       {"r32f", "r16f"},
       {"--quantity", "radiance", "--band", "8,12"}},
      {"illumination",
       3,
       SampleType::kFloat32,
       [](double x, double y, int band) { return std::exp(6.0 * hills(x + 0.1 * band, y)); },
       "average",
       {"rgba16f", "rgb9e5", "bc6h"},
       {}},
      {"mask",
       1,
       SampleType::kUint8,
       [](double x, double y, int) { return hills(x, y) > 0.0 ? 255.0 : 0.0; },
       "average",
       {"r8", "bc4"},
       {}},
  };
}

Result<void> write_input(const ChannelJob& job, std::int64_t size, const std::filesystem::path& path) {
  source::GeoTiffSpec spec;
  spec.width = spec.height = size;
  spec.bands = job.bands;
  spec.sample_type = job.type;
  VT_ASSIGN(auto writer, source::GeoTiffWriter::create(path, spec));
  std::vector<std::byte> row(static_cast<std::size_t>(size * job.bands) * sample_bytes(job.type));
  const auto place = [&](std::int64_t i) { return (static_cast<double>(i) + 0.5) / static_cast<double>(size); };
  for (std::int64_t y = 0; y < size; ++y) {
    std::byte* out = row.data();
    for (std::int64_t x = 0; x < size; ++x)
      for (int band = 0; band < job.bands; ++band, out += sample_bytes(job.type)) {
        const double value = job.value(place(x), place(y), band);
        if (job.type == SampleType::kUint8) {
          *out = static_cast<std::byte>(std::clamp(value, 0.0, 255.0));
        } else {
          const auto number = static_cast<float>(value);
          std::memcpy(out, &number, sizeof number);
        }
      }
    VT_CHECK(writer.write_rows(row, 1));
  }
  VT_CHECK(writer.finish());
  return sync_file(path);
}

std::vector<Contender> contenders_of(const ChannelJob& job, const Input& input, const Setting& setting) {
  std::vector<Contender> contenders;
  const std::string kernel = "box";
  for (const std::string& format : job.formats) {
    Contender ours = our_build({job.channel, kernel, format, "none"}, input.path.string(), false, setting);
    ours.command.arguments.insert(ours.command.arguments.end(), job.options.begin(), job.options.end());
    contenders.push_back(std::move(ours));
  }
  if (setting.with_peers)
    if (auto peer = gdaladdo(job.peer_resampling, {job.channel, kernel, "", "none"}, input, setting))
      contenders.push_back(std::move(*peer));
  return contenders;
}

Result<int> run(const ChannelsFlags& flags) {
  Setting setting;
  VT_ASSIGN(setting.vtbuild, program_beside("vtbuild"));
  VT_ASSIGN(const ScratchFolder scratch, ScratchFolder::create(flags.scratch));
  setting.scratch = scratch.path();
  setting.threads = flags.threads;
  setting.with_peers = !flags.only_ours;
  warn_about_conditions();

  Table table({{"channel", "channel"},
               {"input", "input"},
               {"program", "program"},
               {"format", "format"},
               {"mpx_per_s", "Mpx/s", 0},
               {"to_peer", "x peer", 2},
               {"peak_mib", "peak MiB", 0},
               {"result_mib", "result MiB", 0}});
  const auto path = scratch / "input.tif";
  for (const ChannelJob& job : channel_jobs()) {
    if (!flags.only.empty() && job.channel != flags.only) continue;
    VT_CHECK(write_input(job, flags.size, path));
    VT_ASSIGN(const Input input, open_input(path));
    const std::vector<Contender> contenders = contenders_of(job, input, setting);
    VT_CHECK(warm_up(path));
    VT_ASSIGN(const std::vector<Measured> measured, run_in_turn(contenders, flags.runs));
    const auto rate = [&](std::size_t i) { return input.megapixels() / measured[i].spread().median; };
    const bool has_peer = !contenders.back().is_ours && !measured.back().failed;
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      if (measured[i].failed) continue;
      table.add_named_row({{"channel", job.channel},
                           {"input", fmt::format("{} x {}", job.bands, sample_name(job.type))},
                           {"program", contenders[i].name},
                           {"format", contenders[i].kind.format},
                           {"mpx_per_s", rate(i)},
                           {"to_peer", has_peer && contenders[i].is_ours ? Cell(rate(i) / rate(contenders.size() - 1)) : Cell()},
                           {"peak_mib", static_cast<double>(measured[i].peak_bytes) / kMib},
                           {"result_mib", static_cast<double>(measured[i].output_bytes) / kMib}});
    }
  }
  const std::string heading = fmt::format("{} x {} texels, box, uncompressed; {} threads; median of {} runs; {}", flags.size, flags.size,
                                          flags.threads, flags.runs, this_machine().text());
  VT_CHECK(flags.results.deliver(
      heading, table, "",
      "vtbuild's time includes syncing its store; gdaladdo writes overviews only, and filters numbers whatever they mean.\n"));
  return 0;
}

}  // namespace

std::function<Result<int>()> add_channels_command(CLI::App& app) {
  auto flags = std::make_shared<ChannelsFlags>();
  CLI::App* command = app.add_subcommand("channels", "how fast each channel type is built in each of its formats");
  command->add_option("--size", flags->size, "texels along an edge of the rasters that are made")
      ->capture_default_str()
      ->check(CLI::Range(64, 65536));
  command->add_option("--channel", flags->only, "only this one");
  command->add_option("--runs", flags->runs, "of each program, the median counts")->capture_default_str()->check(CLI::Range(1, 100));
  command->add_option("--threads", flags->threads, "for every program")->capture_default_str()->check(CLI::Range(1, 1024));
  command->add_flag("--only-ours", flags->only_ours, "leave gdaladdo out");
  command->add_option("--scratch", flags->scratch, "folder for what is built (default: the system's temporary folder)");
  flags->results.add_to(*command, false);
  cli::add_help_footer(*command,
                       "  vtbench channels --markdown channels.md\n"
                       "  vtbench channels --channel sensor --size 8192\n");
  return [flags, command]() -> Result<int> { return command->parsed() ? run(*flags) : Result<int>(-1); };
}

}  // namespace vt::bench
