#include "tools/vtbuild/layer_flags.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/pyramid/halving_kernel.h"
#include "builder/source/raster_format.h"
#include "builder/text/names_text.h"
#include "tools/cli/cli_support.h"

namespace vt::tools {
namespace {

// One flag for each option of each channel; several channels may have one of the same name.
void add_channel_options(CLI::App& command, channels::Options& options) {
  struct Use {
    const channels::ChannelKind* kind;
    const channels::OptionInfo* option;
  };
  std::map<std::string, std::vector<Use>> by_name;
  for (const channels::ChannelKind* const kind : channels::all_channels())
    for (const channels::OptionInfo& option : kind->options)
      if (option.name != "alpha") by_name[std::string(option.name)].push_back({kind, &option});  // see --alpha
  for (const auto& [name, uses] : by_name) {
    std::string group = "Options of";
    std::string help;
    for (const Use& use : uses) {
      group += " " + std::string(use.kind->name);
      help += (help.empty() ? "" : "; ") + std::string(use.option->help);
    }
    command.add_option("--" + name, options[name], help)->type_name(std::string(uses.front().option->values))->group(group + " layers");
  }
}

// "kaiser3 for color, box for all others".
std::string usual_kernels_text() {
  const std::string_view most = channels::ChannelKind{}.usual_kernel;
  std::string text;
  for (const channels::ChannelKind* const kind : channels::all_channels())
    if (kind->usual_kernel != most) text += std::string(kind->usual_kernel) + " for " + std::string(kind->name) + ", ";
  return text + std::string(most) + " for all others";
}

// "bilinear, for material nearest": the channels whose layers are counted whatever their options are.
std::string usual_methods_text() {
  std::vector<std::string_view> counted;
  for (const channels::ChannelKind* const kind : channels::all_channels())
    if (!kind->counted({}).empty()) counted.push_back(kind->name);
  const std::string text(resample::method_name(resample::Method::kBilinear));
  if (counted.empty()) return text;
  return text + ", for " + text::names_text(counted) + " " + std::string(resample::method_name(resample::Method::kNearest));
}

// nullopt when the option is not given.
Result<std::optional<Area>> area_from(const std::string& text, const std::string& option) {
  if (text.empty()) return std::optional<Area>{};
  std::array<double, 4> e{};
  VT_CHECK(cli::parse_numbers(text, option, "WEST,SOUTH,EAST,NORTH, four numbers", e));
  // Where a CRS has turns, west > east means across the antimeridian: that is looked at when the CRS is
  // known.
  if (e[0] == e[2] || !(e[1] < e[3]))
    return fail(ErrorCode::kUsage, option + " is WEST,SOUTH,EAST,NORTH with west < east and south < north, found " + text);
  return std::optional(Area{e[0], e[1], e[2], e[3]});
}

// --alpha says which band is coverage, and of colour also whether the codes are multiplied by it: words with
// commas between them.
Result<pipeline::CoverageChoice> coverage_from(const std::string& text, channels::Options& options) {
  pipeline::CoverageChoice choice;
  for (std::size_t at = 0; !text.empty() && at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (word == "associated" || word == "straight") {
      options["alpha"] = word;
    } else {
      const auto chosen = pipeline::coverage_choice_from(word);
      if (!chosen)
        return fail(ErrorCode::kUsage,
                    "--alpha is auto, none or a band's number, and of color also associated or straight, not '" + word + "'");
      choice = *chosen;
    }
    at = end + 1;
  }
  return choice;
}

// nullopt when the option is not given.
Result<std::optional<geo::Crs>> crs_from(const std::string& text) {
  if (text.empty()) return std::optional<geo::Crs>{};
  VT_ASSIGN(geo::Crs crs, geo::Crs::from_text(text));
  return std::optional(std::move(crs));
}

Result<std::optional<std::array<double, 2>>> range_from(const std::string& text) {
  if (text.empty()) return std::optional<std::array<double, 2>>{};
  std::array<double, 2> range{};
  VT_CHECK(cli::parse_numbers(text, "--range", "LOW,HIGH, two numbers", range));
  if (range[0] == range[1]) return fail(ErrorCode::kUsage, "--range needs two different values");
  return std::optional(range);
}

std::size_t list_length(const std::string& text) { return text.empty() ? 0 : static_cast<std::size_t>(std::ranges::count(text, ',') + 1); }

Result<std::vector<int>> bands_from(const std::string& text) {
  std::vector<std::int64_t> numbers(list_length(text));
  if (!numbers.empty()) VT_CHECK(cli::parse_integers(text, "--bands", "whole numbers with commas, for example 3,2,1", numbers));
  std::vector<int> bands;
  for (const std::int64_t n : numbers) {
    if (!std::in_range<int>(n)) return fail(ErrorCode::kUsage, "--bands: there is no band " + std::to_string(n));
    bands.push_back(static_cast<int>(n));
  }
  return bands;
}

Result<std::vector<double>> nodata_from(const std::string& text) {
  std::vector<double> nodata(list_length(text));
  if (!nodata.empty()) VT_CHECK(cli::parse_numbers(text, "--nodata", "one number, or one for each band with commas between them", nodata));
  return nodata;
}

}  // namespace

Result<pipeline::LayerRequest> asked_request(const LayerFlags& flags) {
  pipeline::LayerRequest asked;
  const channels::ChannelKind* const channel = channels::find_channel(flags.channel);
  if (channel == nullptr) return fail(ErrorCode::kUsage, "unknown channel '" + flags.channel + "'; known are " + channels::channel_names());
  asked.channel = channel->type;
  asked.name = flags.name.empty() ? flags.channel : flags.name;
  if (!flags.format.empty()) {
    asked.format = format_from_name(flags.format);
    if (!asked.format)
      return fail(ErrorCode::kUsage,
                  "unknown format '" + flags.format + "'; known are " + format_names() + ", of which each channel takes some");
  }
  asked.kernel = flags.kernel;
  const auto quality = encode::quality_from_name(flags.quality);
  if (!quality) return fail(ErrorCode::kUsage, "--quality is fast, normal or best, not '" + flags.quality + "'");
  asked.quality = *quality;
  asked.compression = flags.compression;
  asked.tile_texels = flags.tile;
  if (flags.gsd != 0.0) asked.gsd_m = flags.gsd;
  VT_ASSIGN(asked.crs, crs_from(flags.crs));
  VT_ASSIGN(asked.range, range_from(flags.range));
  VT_ASSIGN(asked.area, area_from(flags.area, "--area"));
  if (!flags.resample.empty()) {
    asked.resample = resample::method_from_name(flags.resample);
    if (!asked.resample) return fail(ErrorCode::kUsage, "--resample is nearest or bilinear, not '" + flags.resample + "'");
  }
  for (const auto& [name, value] : flags.options)
    if (!value.empty()) asked.options[name] = value;

  pipeline::SourceRequest source;
  VT_ASSIGN(source.crs, crs_from(flags.source_crs));
  // --crs is the dataset's. A file without one is taken to be in it too, unless --source-crs says otherwise;
  // so is a picture placed by --extent.
  if (!source.crs) source.fallback_crs = asked.crs;
  VT_ASSIGN(source.extent, area_from(flags.extent, "--extent"));
  VT_ASSIGN(source.nodata, nodata_from(flags.nodata));
  VT_ASSIGN(source.bands, bands_from(flags.bands));
  VT_ASSIGN(source.coverage, coverage_from(flags.alpha, asked.options));
  for (const std::string& input : flags.inputs) {
    source.path = input;
    asked.sources.push_back(source);
  }
  VT_CHECK(channels::check_options(asked.channel, asked.options));
  return asked;
}

void LayerFlags::add_to(CLI::App& command) {
  command
      .add_option("INPUT", inputs,
                  "rasters (" + source::names_of_read_formats() +
                      "); pictures without a place on the ground need --extent; a folder means the rasters in it, sorted by name, and "
                      "@FILE those that a text file lists, one a line; later ones lie over earlier ones")
      ->required();
  command.add_option("-o,--output", output, "the store, suffix .vts");
  command.add_option("--channel", channel, "what the values mean: " + channels::channel_names())->required();
  command.add_option("--name", name, "name of the layer (default: the channel's)");
  command.add_option("--kernel", kernel,
                     "filter from level to level: " + text::names_text(pyramid::all_kernels(), &pyramid::HalvingKernel::name) +
                         " (default: " + usual_kernels_text() + "; point is for heights that displace)");
  command.add_option("--format", format, "texel format (default: what the channel and the source suggest)");
  command.add_option("--quality", quality, "effort of block compression: fast, normal or best")->capture_default_str();
  command.add_option("--compression", compression, "none or zstd:N, N from 1 to 19")->capture_default_str();
  command.add_option("--tile", tile, "texels along an edge of a tile, a power of two from 4 to 4096")->capture_default_str();
  command.add_option("--gsd", gsd, "metres on the ground per texel of the finest level (default: the first input's own grid)");
  command.add_option("--crs", crs,
                     "coordinate reference system of the dataset, for example EPSG:32633, or pixel (default: the first input's); also that "
                     "of inputs that declare none");
  command.add_option("--source-crs", source_crs, "what the inputs are in, whatever the files declare");
  command.add_option("--extent", extent,
                     "WEST,SOUTH,EAST,NORTH: outer edges of inputs that do not carry them; here and in --area west > east lies across the "
                     "antimeridian");
  command.add_option("--area", area,
                     "WEST,SOUTH,EAST,NORTH of the layer in units of its system, widened to whole texels (default: all that the inputs "
                     "cover); inputs may come later, with --update");
  command.add_option(
      "--resample", resample,
      std::string("for inputs on another grid: bilinear, or nearest, which keeps samples as they are and moves a grid that is off by part "
                  "of a texel; where a texel lies over several samples, all count by their area (default: ") +
          usual_methods_text() + ")");
  command.add_option("--bands", bands, "exactly the bands to use, counted from 1, for example 3,2,1");
  command.add_option(
      "--alpha", alpha,
      "what says how much of a sample is covered: auto (a mask, or the alpha band that the file declares, unless --bands names "
      "others), none, or a band's number; of color also associated, when codes are multiplied by their coverage although "
      "the file does not say so (default: auto)");
  command.add_option(
      "--range", range,
      "LOW,HIGH: sample values that are black and white (default: all of an 8 or 16 bit unsigned type; others need it); of elevation "
      "stored as r16, the lowest and highest height in metres");
  command.add_option("--nodata", nodata,
                     "sample value that means no data, whatever the files say; of a palette the index; or one for each band, as a colour "
                     "key: 255,255,252");
  add_channel_options(command, options);
}

}  // namespace vt::tools
