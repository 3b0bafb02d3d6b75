// vtbuild layer: one layer from one or more rasters.

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <utility>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/blocks/dataset_store.h"
#include "builder/pipeline/request/input_list.h"
#include "builder/pipeline/request/option_files.h"
#include "tools/cli/setting_names.h"
#include "tools/vtbuild/build_flags.h"
#include "tools/vtbuild/recipe.h"

namespace vt::tools {
namespace {

struct LayerFlags {
  std::vector<std::string> inputs;
  std::string output;
  std::string channel;
  std::string name;
  std::string kernel;
  std::string format;
  std::string quality = "normal";
  std::string compression = "zstd:3";
  int tile = 256;
  double gsd = 0.0;
  std::string crs;
  std::string source_crs;
  std::string extent;
  std::string bands;
  std::string range;
  std::string nodata;
  std::string alpha;
  std::string area;
  std::string resample;
  channels::Options options;
  BuildFlags build;
};

template <class List>
std::string names_of(const List& list) {
  std::string names;
  for (const auto& item : list) names += (names.empty() ? "" : ", ") + std::string(item.name);
  return names;
}

std::string channel_names() {
  std::string names;
  for (const channels::ChannelKind* const kind : channels::all_channels()) names += (names.empty() ? "" : ", ") + std::string(kind->name);
  return names;
}

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

// nullopt when the option is not given.
Result<std::optional<Area>> area_from(const std::string& text, const std::string& option) {
  if (text.empty()) return std::optional<Area>{};
  std::array<double, 4> e{};
  VT_CHECK(cli::parse_numbers(text, option, "WEST,SOUTH,EAST,NORTH, four numbers", e));
  // Where a CRS has turns, west > east means across the antimeridian: that is looked at when the CRS is known.
  if (e[0] == e[2] || !(e[1] < e[3]))
    return fail(ErrorCode::kUsage, option + " is WEST,SOUTH,EAST,NORTH with west < east and south < north, found " + text);
  return std::optional(Area{e[0], e[1], e[2], e[3]});
}

// --alpha says which band is coverage, and of colour also whether the codes are multiplied by it: words with commas between them.
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

Result<pipeline::LayerRequest> request_from(const LayerFlags& flags, const std::optional<pipeline::DatasetFrame>& frame) {
  pipeline::LayerRequest request;
  const channels::ChannelKind* const channel = channels::find_channel(flags.channel);
  if (channel == nullptr) return fail(ErrorCode::kUsage, "unknown channel '" + flags.channel + "'; known are " + channel_names());
  request.channel = channel->type;
  request.name = flags.name.empty() ? flags.channel : flags.name;
  if (!flags.format.empty()) {
    request.format = format_from_name(flags.format);
    if (!request.format)
      return fail(ErrorCode::kUsage, "unknown format '" + flags.format +
                                         "'; known are rgb8, rgba8, r8, rg8, r16, rg16, rgba16, r16f, rg16f, rgba16f, r32f, rg32f, "
                                         "rgba32f, rgb9e5, bc1, bc3, bc4, bc5, bc6h and bc7, of which each channel takes some");
  }
  request.kernel = flags.kernel;
  const auto quality = encode::quality_from_name(flags.quality);
  if (!quality) return fail(ErrorCode::kUsage, "--quality is fast, normal or best, not '" + flags.quality + "'");
  request.quality = *quality;
  request.compression = flags.compression;
  request.tile_texels = flags.tile;
  if (flags.gsd != 0.0) request.gsd_m = flags.gsd;
  std::optional<geo::Crs> crs;
  if (!flags.crs.empty()) {
    VT_ASSIGN(crs, geo::Crs::from_text(flags.crs));
  }
  std::optional<geo::Crs> source_crs;
  if (!flags.source_crs.empty()) {
    VT_ASSIGN(source_crs, geo::Crs::from_text(flags.source_crs));
  }
  if (!flags.range.empty()) {
    std::array<double, 2> range{};
    VT_CHECK(cli::parse_numbers(flags.range, "--range", "LOW,HIGH, two numbers", range));
    if (range[0] == range[1]) return fail(ErrorCode::kUsage, "--range needs two different values");
    request.range = range;
  }
  VT_ASSIGN(const std::optional<Area> extent, area_from(flags.extent, "--extent"));
  VT_ASSIGN(request.area, area_from(flags.area, "--area"));
  if (!flags.resample.empty()) {
    request.resample = resample::method_from_name(flags.resample);
    if (!request.resample) return fail(ErrorCode::kUsage, "--resample is nearest or bilinear, not '" + flags.resample + "'");
  }
  for (const auto& [name, value] : flags.options)
    if (!value.empty()) request.options[name] = value;
  VT_ASSIGN(const pipeline::CoverageChoice coverage, coverage_from(flags.alpha, request.options));
  VT_CHECK(channels::check_options(request.channel, request.options));
  VT_CHECK(pipeline::load_option_files(request.channel, std::filesystem::current_path(), request.options));
  std::vector<int> bands;
  if (!flags.bands.empty()) {
    const auto count = static_cast<std::size_t>(std::count(flags.bands.begin(), flags.bands.end(), ',') + 1);
    std::vector<std::int64_t> numbers(count);
    VT_CHECK(cli::parse_integers(flags.bands, "--bands", "whole numbers with commas, for example 3,2,1", numbers));
    for (const std::int64_t n : numbers) {
      if (!std::in_range<int>(n)) return fail(ErrorCode::kUsage, "--bands: there is no band " + std::to_string(n));
      bands.push_back(static_cast<int>(n));
    }
  }
  std::vector<double> nodata;
  if (!flags.nodata.empty()) {
    nodata.resize(static_cast<std::size_t>(std::count(flags.nodata.begin(), flags.nodata.end(), ',') + 1));
    VT_CHECK(cli::parse_numbers(flags.nodata, "--nodata", "one number, or one for each band with commas between them", nodata));
  }

  // --crs is the dataset's. A file without one is taken to be in it too, unless --source-crs says otherwise; so is a picture placed by
  // --extent.
  request.crs = frame ? std::nullopt : crs;
  std::vector<std::filesystem::path> inputs;
  for (const std::string& input : flags.inputs) {
    VT_ASSIGN(const std::vector<std::filesystem::path> files, pipeline::expand_input(input));
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  for (const std::filesystem::path& input : inputs) {
    pipeline::SourceRequest source;
    source.path = input;
    source.crs = source_crs;
    source.extent = extent;
    source.nodata = nodata;
    source.bands = bands;
    source.coverage = coverage;
    request.sources.push_back(std::move(source));
  }
  if (frame && crs && !frame->crs.same_coordinates(*crs))
    return fail(ErrorCode::kUsage, flags.output + " is in " + frame->crs.text() + "; its layers cannot be in " + crs->text());
  if (!source_crs && crs)
    for (pipeline::SourceRequest& source : request.sources) source.fallback_crs = crs;
  return request;
}

Result<int> run(const LayerFlags& flags) {
  VT_ASSIGN(const auto frame, pipeline::existing_frame(flags.output));
  VT_ASSIGN(const pipeline::LayerRequest request, request_from(flags, frame));
  VT_ASSIGN(const std::size_t memory, flags.build.memory_bytes());
  VT_ASSIGN(pipeline::LayerPlan plan, pipeline::plan_layer(request, frame, flags.build.plan_options(memory, flags.output)));
  const Area extent = plan.extent();
  std::vector<pipeline::LayerPlan> plans;
  plans.push_back(std::move(plan));
  return build_layers(flags.output, std::move(plans), extent, flags.build);
}

CLI::App* add_command(CLI::App& app, const std::shared_ptr<LayerFlags>& flags) {
  CLI::App* command = app.add_subcommand("layer", "build one layer from georeferenced rasters, into a new store or one that exists");
  command
      ->add_option("INPUT", flags->inputs,
                   "GeoTIFF, or a picture (PNG, JPEG, JPEG 2000, OpenEXR, Radiance HDR, PNM) with --extent; a folder means the rasters in "
                   "it, sorted by name, and @FILE those that a "
                   "text file lists, one a line; later ones lie over earlier ones")
      ->required();
  command->add_option("-o,--output", flags->output, "the store, suffix .vts")->required();
  command->add_option("--channel", flags->channel, "what the values mean: " + channel_names())->required();
  command->add_option("--name", flags->name, "name of the layer (default: the channel's)");
  command->add_option("--kernel", flags->kernel,
                      "filter from level to level: " + names_of(pyramid::all_kernels()) +
                          " (default: kaiser3 for color, box for all others; point is for heights that displace)");
  command->add_option("--format", flags->format, "texel format (default: what the channel and the source suggest)");
  command->add_option("--quality", flags->quality, "effort of block compression: fast, normal or best")->capture_default_str();
  command->add_option("--compression", flags->compression, "none or zstd:N, N from 1 to 19")->capture_default_str();
  command->add_option("--tile", flags->tile, "texels along an edge of a tile, a power of two from 4 to 4096")->capture_default_str();
  command->add_option("--gsd", flags->gsd, "metres on the ground per texel of the finest level (default: the first input's own grid)");
  command->add_option(
      "--crs", flags->crs,
      "coordinate reference system of the dataset, for example EPSG:32633, or pixel (default: the first input's); also that "
      "of inputs that declare none");
  command->add_option("--source-crs", flags->source_crs, "what the inputs are in, whatever the files declare");
  command->add_option("--extent", flags->extent,
                      "WEST,SOUTH,EAST,NORTH: outer edges of inputs that do not carry them; here and in --area west > east lies across the "
                      "antimeridian");
  command->add_option("--area", flags->area,
                      "WEST,SOUTH,EAST,NORTH of the layer in units of its system, widened to whole texels (default: all that the inputs "
                      "cover); inputs may come later, with --update");
  command->add_option(
      "--resample", flags->resample,
      "for inputs on another grid: bilinear, or nearest, which keeps samples as they are and moves a grid that is off by part "
      "of a texel; where a texel lies over several samples, all count by their area (default: bilinear, for material nearest)");
  command->add_option("--bands", flags->bands, "exactly the bands to use, counted from 1, for example 3,2,1");
  command->add_option(
      "--alpha", flags->alpha,
      "what says how much of a sample is covered: auto (a mask, or the alpha band that the file declares, unless --bands names "
      "others), none, or a band's number; of color also associated, when codes are multiplied by their coverage although "
      "the file does not say so (default: auto)");
  command->add_option(
      "--range", flags->range,
      "LOW,HIGH: sample values that are black and white (default: all of an 8 or 16 bit unsigned type; others need it); of elevation "
      "stored as r16, the lowest and highest height in metres");
  command->add_option("--nodata", flags->nodata,
                      "sample value that means no data, whatever the files say; of a palette the index; or one for each band, as a colour "
                      "key: 255,255,252");
  add_channel_options(*command, flags->options);
  flags->build.add_to(*command);
  cli::put_flags_in_help(*command);
  cli::add_help_footer(*command,
                       "  vtbuild layer ortho.tif -o area.vts --channel color\n"
                       "  vtbuild layer dem.tif -o area.vts --channel elevation\n"
                       "  vtbuild layer tiles/ -o area.vts --channel color\n"
                       "  vtbuild layer @tiles.txt -o area.vts --channel color\n"
                       "  vtbuild layer west.tif east.tif -o area.vts --channel color --format bc1 --compression zstd:9\n"
                       "  vtbuild layer earth.jpg -o earth.vts --channel color --crs EPSG:4326 --extent -180,-90,180,90\n"
                       "  vtbuild layer scan.png -o scan.vts --channel color --crs pixel\n");
  return command;
}

}  // namespace

std::function<Result<int>()> add_layer_command(CLI::App& app, std::shared_ptr<nlohmann::ordered_json> report) {
  auto flags = std::make_shared<LayerFlags>();
  flags->build.report = std::move(report);
  CLI::App* command = add_command(app, flags);
  return [flags, command]() -> Result<int> {
    if (!command->parsed()) return -1;
    flags->build.recipe = recipe_of(*command, flags->output);
    VT_CHECK(check_recipe(flags->build.recipe));
    return run(*flags);
  };
}

Result<pipeline::LayerRequest> layer_request_of(std::vector<std::string> arguments, const std::filesystem::path& raster,
                                                const pipeline::DatasetFrame& frame) {
  CLI::App app;
  app.require_subcommand(1);
  auto flags = std::make_shared<LayerFlags>();
  add_command(app, flags);
  arguments.insert(arguments.begin() + 1, "--output=none.vts");  // behind "--" it would be an input
  std::ranges::reverse(arguments);                               // CLI11 takes them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& problem) {
    return fail(ErrorCode::kInvalidData, std::string("the command that the layer was built by is not understood: ") + problem.what());
  }
  flags->inputs = {raster.string()};
  return request_from(*flags, frame);
}

}  // namespace vt::tools
