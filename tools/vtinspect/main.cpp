// vtinspect: shows, checks, samples, compares and extracts what a store holds. Only the command line is here;
// each subcommand has a file.
#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <string>

#include "tools/cli/cli_support.h"
#include "tools/vtinspect/compare.h"
#include "tools/vtinspect/extract.h"
#include "tools/vtinspect/info.h"
#include "tools/vtinspect/sample.h"
#include "tools/vtinspect/validate.h"

namespace {

using namespace vt;
using namespace vt::inspect;

constexpr const char* kStoreHelp = "the store (.vts)";
constexpr const char* kLayerHelp = "the layer's name; may be left out when the store has one";
constexpr const char* kLevelHelp = "0 is the coarsest; default: the finest";

using Command = std::function<Result<int>()>;

void add_progress(CLI::App& app, cli::ProgressMode& mode) {
  static const std::map<std::string, cli::ProgressMode> modes = {
      {"auto", cli::ProgressMode::kAuto}, {"plain", cli::ProgressMode::kPlain}, {"none", cli::ProgressMode::kNone}};
  app.add_option("--progress", mode, "a bar on a terminal and lines elsewhere, always lines, or nothing")
      ->transform(CLI::Transformer(modes).description(""))
      ->type_name("auto|plain|none");
}

void add_info(CLI::App& app, InfoOptions& options, Command& command) {
  CLI::App* const sub = app.add_subcommand("info", "Show layers, levels, sizes and places");
  sub->add_option("STORE", options.store, kStoreHelp)->required();
  sub->add_flag("--json", options.json, "JSON, as schemas/vtinspect-info.schema.json describes it");
  sub->add_flag("--names", options.names_only, "only the names of the texture layers, one a line");
  cli::add_help_footer(*sub, "  vtinspect info base.vts\n  vtinspect info base.vts --json | jq .layers[0].levels");
  sub->callback([&] { command = [&] { return run_info(options); }; });
}

void add_validate(CLI::App& app, ValidateCommand& options, Command& command) {
  CLI::App* const sub = app.add_subcommand("validate", "Check every byte of a store");
  sub->add_option("STORE", options.store, kStoreHelp)->required();
  sub->add_flag("--json", options.json, "JSON, as schemas/vtinspect-validate.schema.json describes it");
  sub->add_flag("--quick", options.quick, "check sums only; do not unpack the tiles");
  sub->add_option("--sample", options.sample, "check so many tiles only, found by random ways down the index, with all pages on the way")
      ->type_name("N");
  sub->add_option("--seed", options.seed, "of the sample")->type_name("S")->capture_default_str();
  add_progress(*sub, options.progress);
  cli::add_help_footer(*sub,
                       "  vtinspect validate base.vts\n  vtinspect validate base.vts --quick --progress none\n"
                       "  vtinspect validate planet.vts --sample 100000");
  sub->callback([&] { command = [&] { return run_validate(options); }; });
}

void add_extract(CLI::App& app, ExtractOptions& options, Command& command) {
  CLI::App* const sub = app.add_subcommand("extract", "Write a level, or a window of it, as a picture or a GeoTIFF");
  sub->add_option("STORE", options.store, kStoreHelp)->required();
  sub->add_option("-o,--output", options.output, "OUT.png, OUT.exr (float layers) or OUT.tif (georeferenced)")->required();
  sub->add_option("--layer", options.choice.layer, kLayerHelp)->type_name("NAME");
  CLI::Option* const level = sub->add_option("--level", options.choice.level, kLevelHelp)->type_name("L");
  CLI::Option* const window =
      sub->add_option("--window", options.window, "columns and rows count in the level's data rectangle")->type_name("X,Y,W,H");
  sub->add_flag("--mosaic", options.mosaic, "all levels side by side on one PNG")->excludes(level)->excludes(window);
  add_progress(*sub, options.progress);
  cli::add_help_footer(
      *sub,
      "  vtinspect extract base.vts -o base.tif\n"
      "  vtinspect extract base.vts --layer elevation --level 3 --window 0,0,512,512 -o corner.exr\n"
      "  vtinspect extract base.vts --layer color --mosaic -o levels.png\n\n"
      "Without data a GeoTIFF has GDAL_NODATA in heights (the source's number, or NaN), in directions, angles and radiance (NaN) "
      "and in classes\n(the one that stands for none); coverage 0 in the last band of colours and of light; and 0 in masks and "
      "shares. Filled voids have their height.");
  sub->callback([&] { command = [&] { return run_extract(options); }; });
}

void add_sample(CLI::App& app, SampleOptions& options, Command& command) {
  CLI::App* const sub = app.add_subcommand("sample", "Show one texel and where it is, in every coordinate system");
  sub->add_option("STORE", options.store, kStoreHelp)->required();
  sub->add_option("--layer", options.choice.layer, kLayerHelp)->type_name("NAME");
  sub->add_option("--level", options.choice.level, kLevelHelp)->type_name("L");
  CLI::Option_group* const place = sub->add_option_group("place", "exactly one of");
  place->add_option("--lonlat", options.lonlat, "degrees on the store's own datum")->type_name("LON,LAT");
  place->add_option("--texel", options.texel, "column and row in the level's data rectangle")->type_name("X,Y");
  place->add_option("--uv", options.uv, "0..1 over the area, from its south-west corner")->type_name("U,V");
  place->require_option(1);
  sub->add_flag("--json", options.json, "JSON, as schemas/vtinspect-sample.schema.json describes it");
  cli::add_help_footer(*sub,
                       "  vtinspect sample base.vts --lonlat 11.5,48.1\n"
                       "  vtinspect sample base.vts --layer elevation --level 0 --texel 10,20 --json\n"
                       "  vtinspect sample base.vts --uv 0.5,0.5");
  sub->callback([&] { command = [&] { return run_sample(options); }; });
}

void add_compare(CLI::App& app, CompareOptions& options, Command& command) {
  CLI::App* const sub =
      app.add_subcommand("compare", "Compare two stores, or a layer's finest level with a raster; exit code 3 when they differ");
  sub->add_option("A", options.first, kStoreHelp)->required();
  sub->add_option(
         "B", options.second,
         "another store, or a raster: one that the layer was built from, read as it was then, or one with the values of its texels")
      ->required();
  sub->add_option("--layer", options.layer, "compare only this layer")->type_name("NAME");
  sub->add_flag("--all", options.all, "carry layers too");
  sub->add_option(
         "--tolerance", options.tolerance,
         "greatest absolute error that still counts as the same, in codes (color) or in the layer's unit; for classes there is none")
      ->type_name("T");
  sub->add_flag("--json", options.json, "JSON, as schemas/vtinspect-compare.schema.json describes it");
  add_progress(*sub, options.progress);
  cli::add_help_footer(*sub,
                       "  vtinspect compare yesterday.vts today.vts\n"
                       "  vtinspect compare base.vts source.tif --layer color --tolerance 1");
  sub->callback([&] { command = [&] { return run_compare(options); }; });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Shows, checks, samples, compares and extracts what a virtual-texture store holds.", "vtinspect");
  app.require_subcommand(1);
  app.set_version_flag("--version", "vtinspect " VT_VERSION);
  cli::add_help_footer(app,
                       "  vtinspect info base.vts\n"
                       "  vtinspect validate base.vts\n"
                       "  vtinspect extract base.vts --mosaic -o levels.png\n"
                       "Each subcommand has its own --help.");

  InfoOptions info;
  ValidateCommand validate;
  ExtractOptions extract;
  SampleOptions sample;
  CompareOptions compare;
  Command command;
  add_info(app, info, command);
  add_validate(app, validate, command);
  add_extract(app, extract, command);
  add_sample(app, sample, command);
  add_compare(app, compare, command);
  return cli::run_main(app, argc, argv, [&] { return command(); });
}
