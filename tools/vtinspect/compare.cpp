#include "tools/vtinspect/compare.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "store/format/text.h"
#include "tools/vtinspect/comparison.h"

namespace vt::inspect {

namespace {

nlohmann::ordered_json number_or_null(const std::optional<double>& number) {
  return number ? nlohmann::ordered_json(*number) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json measured_json(const MeasuredError& measured) {
  return {{"name", measured.name},         {"unit", measured.unit},         {"texels", measured.error.count},
          {"max", measured.error.largest}, {"mean", measured.error.mean()}, {"rms", measured.error.root_mean_square()}};
}

nlohmann::ordered_json level_json(const LayerDifference& layer, const LevelDifference& level) {
  nlohmann::ordered_json json = {
      {"level", level.level},
      {"tiles", level.tiles},
      {"differing_tiles", level.differing_tiles},
      {"only_in_first", level.only_in_first},
      {"only_in_second", level.only_in_second},
      {"texels", level.texels},
      {"differing_texels", level.differing_texels},
      {"hole_mismatches", level.hole_mismatches()},
      {"data_only_in_first", level.data_only_in_first},
      {"data_only_in_second", level.data_only_in_second},
      {"misfits", level.misfits},
      {"max_error", level.values.largest},
      {"mean_error", level.values.mean()},
      {"rms_error", level.values.root_mean_square()},
      {"psnr_codes_db", layer.is_byte_format ? number_or_null(psnr_of(level.values, 255.0)) : nullptr},
      {"psnr_linear_db", layer.is_srgb ? number_or_null(psnr_of(level.linear, 1.0)) : nullptr},
      {"measured", nlohmann::ordered_json::array()},
  };
  for (const MeasuredError& measured : level.measured) json["measured"].push_back(measured_json(measured));
  return json;
}

nlohmann::ordered_json to_json(const CompareOptions& options, const Comparison& comparison) {
  nlohmann::ordered_json json = {
      {"first", options.first.string()},
      {"second", options.second.string()},
      {"equal", comparison.is_equal()},
      {"tolerance", options.tolerance},
      {"within_tolerance", comparison.is_within(options.tolerance)},
      {"mismatches", comparison.mismatches},
      {"remarks", comparison.remarks},
      {"raster", nullptr},
      {"layers", nlohmann::ordered_json::array()},
  };
  if (comparison.raster) {
    const TexelRect& rect = comparison.raster->compared;
    json["raster"] = {{"read_as", comparison.raster->as_source ? "source" : "values"},
                      {"compared", {{"x", rect.x}, {"y", rect.y}, {"width", rect.width}, {"height", rect.height}}}};
  }
  for (const LayerDifference& layer : comparison.layers) {
    nlohmann::ordered_json levels = nlohmann::ordered_json::array();
    for (const LevelDifference& level : layer.levels) levels.push_back(level_json(layer, level));
    json["layers"].push_back({{"name", layer.name}, {"levels", levels}});
  }
  return json;
}

std::string level_table(const LayerDifference& layer) {
  constexpr std::string_view kRow = "  {:>5} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9} {:>9}  {:>12} {:>12} {:>12}  {:>10} {:>10}\n";
  std::string text = fmt::format("layer {}:\n", layer.name);
  text += fmt::format(fmt::runtime(kRow), "level", "tiles", "differing", "only 1st", "only 2nd", "texels", "data 1st", "data 2nd",
                      "max error", "mean error", "rms error", "PSNR codes", "PSNR light");
  for (const LevelDifference& level : layer.levels) {
    const auto decibels = [](bool applies, const std::optional<double>& psnr) {
      return !applies ? std::string("-") : psnr ? fmt::format("{:.2f} dB", *psnr) : std::string("no error");
    };
    text += fmt::format(fmt::runtime(kRow), level.level, level.tiles, level.differing_tiles, level.only_in_first, level.only_in_second,
                        level.differing_texels, level.data_only_in_first, level.data_only_in_second,
                        fmt::format("{:.6g}", level.values.largest), fmt::format("{:.6g}", level.values.mean()),
                        fmt::format("{:.6g}", level.values.root_mean_square()),
                        decibels(layer.is_byte_format, psnr_of(level.values, 255.0)), decibels(layer.is_srgb, psnr_of(level.linear, 1.0)));
  }
  return text;
}

std::string holes_text(const LevelDifference& level, const CompareOptions& options) {
  std::string text;
  const auto add = [&](std::uint64_t count, const std::filesystem::path& where) {
    if (count > 0) text += fmt::format("level {}: {} texels have data only in {}\n", level.level, count, where.string());
  };
  add(level.data_only_in_first, options.first);
  add(level.data_only_in_second, options.second);
  return text;
}

// How the raster was understood, and how far the store is from it in the channel's own terms.
std::string raster_text(const CompareOptions& options, const Comparison& comparison) {
  const RasterReading& reading = *comparison.raster;
  std::string text =
      fmt::format("{}: {} x {} texels compared, {}\n", options.second.string(), reading.compared.width, reading.compared.height,
                  reading.as_source ? "read as the layer's sources were" : "read as values of the layer's texels");
  for (const LayerDifference& layer : comparison.layers)
    for (const MeasuredError& measured : layer.levels.front().measured)
      if (measured.error.count > 0)
        text += fmt::format("  {}: stored within {:.6g}{}{} of the raster, rms {:.6g}\n", store::printable(measured.name),
                            measured.error.largest, measured.unit.empty() ? "" : " ", measured.unit, measured.error.root_mean_square());
  return text;
}

std::string to_text(const CompareOptions& options, const Comparison& comparison) {
  std::string text;
  for (const std::string& mismatch : comparison.mismatches) text += mismatch + "\n";
  for (const LayerDifference& layer : comparison.layers) {
    const bool is_equal = std::ranges::all_of(layer.levels, [](const LevelDifference& level) {
      return level.differing_tiles == 0 && level.only_in_first == 0 && level.only_in_second == 0;
    });
    text += is_equal ? fmt::format("layer {}: equal\n", layer.name) : level_table(layer);
    for (const LevelDifference& level : layer.levels) text += holes_text(level, options);
  }
  if (comparison.raster) text += raster_text(options, comparison);
  for (const std::string& remark : comparison.remarks) text += remark + "\n";
  if (comparison.is_equal()) {
    text += comparison.raster && comparison.raster->as_source ? "equal: a build from this raster would store the same\n" : "equal\n";
  } else if (comparison.is_within(options.tolerance)) {
    text += fmt::format("different, but within the tolerance of {:g}\n", options.tolerance);
  } else {
    text += "different\n";
  }
  return text;
}

// By what it holds; a file that cannot be opened is for the reader of stores or rasters to name.
bool is_store(const std::filesystem::path& path) {
  if (path.extension() == ".vts") return true;
  std::array<char, 8> magic{};
  std::ifstream file(path, std::ios::binary);
  return std::filesystem::is_regular_file(path) && file.read(magic.data(), magic.size()) &&
         std::string_view(magic.data(), magic.size()) == "VTSTORE1";
}

}  // namespace

Result<int> run_compare(const CompareOptions& options) {
  if (!(options.tolerance >= 0.0)) return fail(ErrorCode::kUsage, "compare: --tolerance must not be negative");
  VT_ASSIGN(const Comparison comparison, is_store(options.second) ? compare_stores(options) : compare_with_raster(options));
  if (options.json) {
    cli::print_json(to_json(options, comparison));
  } else {
    cli::print(to_text(options, comparison));
  }
  return comparison.is_within(options.tolerance) ? 0 : cli::exit_code(ErrorCode::kInvalidData);
}

}  // namespace vt::inspect
