#include "builder/pipeline/request/request_json.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/request/dataset_schema.h"

namespace vt::pipeline {
namespace {

using nlohmann::json;
using Json = nlohmann::ordered_json;

// The coordinate reference system that `text` names; `where` is its place in the file.
Result<geo::Crs> crs_from(const std::string& text, const std::string& where) {
  auto crs = geo::Crs::from_text(text);
  if (!crs) return fail(crs.error().code, where + ": " + crs.error().message);
  return crs;
}

// A source names one raster, or a folder or a list of them that are all read in the same way.
Result<SourceRequest> source_from(const json& value, const std::string& where) {
  SourceRequest source;
  if (value.is_string()) {
    source.path = value.get<std::string>();
    return source;
  }
  source.path = value.at("file").get<std::string>();
  if (value.contains("crs")) {
    VT_ASSIGN(source.stated_crs, crs_from(value["crs"].get<std::string>(), where + "/crs"));
  }
  if (value.contains("source_crs")) {
    VT_ASSIGN(source.crs, crs_from(value["source_crs"].get<std::string>(), where + "/source_crs"));
  }
  if (value.contains("fallback_crs")) {
    VT_ASSIGN(source.fallback_crs, crs_from(value["fallback_crs"].get<std::string>(), where + "/fallback_crs"));
  }
  if (value.contains("extent")) {
    const json& e = value["extent"];
    source.extent = Area{e[0].get<double>(), e[1].get<double>(), e[2].get<double>(), e[3].get<double>()};
  }
  if (value.contains("nodata"))
    source.nodata = value["nodata"].is_array() ? value["nodata"].get<std::vector<double>>() : std::vector{value["nodata"].get<double>()};
  if (value.contains("bands")) source.bands = value["bands"].get<std::vector<int>>();
  if (value.contains("alpha")) {
    VT_ASSIGN(source.coverage,
              coverage_choice_from(value["alpha"].is_string() ? value["alpha"].get<std::string>() : value["alpha"].dump()));
  }
  return source;
}

Result<ExpectedSamples> expected_from(const json& value, const std::string& where) {
  ExpectedSamples expected;
  const std::string type = value.at("type").get<std::string>();
  const auto known = sample_type_from_name(type);
  if (!known) return fail(ErrorCode::kInvalidData, where + "/type: unknown sample type '" + type + "'");
  expected.type = *known;
  expected.bands = value.at("bands").get<int>();
  expected.has_alpha = value.value("alpha", false);
  if (value.contains("nodata")) expected.nodata = value["nodata"].get<double>();
  return expected;
}

// ---- The writer: in the order of the schema ----

Result<std::string> crs_name(const geo::Crs& crs) {
  if (crs.kind() == geo::CrsKind::kPixel) return std::string("pixel");
  if (crs.definition().epsg != 0) return "EPSG:" + std::to_string(crs.definition().epsg);
  return fail(ErrorCode::kUnsupported, crs.text() + " has no EPSG code, by which a request names coordinate reference systems");
}

Result<void> put_crs(Json& out, const char* key, const std::optional<geo::Crs>& crs) {
  if (!crs) return {};
  VT_ASSIGN(out[key], crs_name(*crs));
  return {};
}

// An input keeps the @ of a list in front of its path, and gets none from the folder.
std::string input_from(const std::filesystem::path& folder, const std::filesystem::path& input) {
  const std::string text = input.generic_string();
  if (text.starts_with('@')) return "@" + (folder / text.substr(1)).generic_string();
  std::string joined = (folder / input).generic_string();
  return joined.starts_with('@') ? "./" + joined : joined;
}

Result<Json> source_json(const SourceRequest& source, const std::filesystem::path& folder) {
  Json out;
  out["file"] = input_from(folder, source.path);
  VT_CHECK(put_crs(out, "crs", source.stated_crs));
  VT_CHECK(put_crs(out, "source_crs", source.crs));
  VT_CHECK(put_crs(out, "fallback_crs", source.fallback_crs));
  if (source.extent) out["extent"] = {source.extent->west, source.extent->south, source.extent->east, source.extent->north};
  if (source.nodata.size() == 1) out["nodata"] = source.nodata.front();
  if (source.nodata.size() > 1) out["nodata"] = source.nodata;
  switch (source.coverage.kind) {
    case CoverageChoice::Kind::kAuto:
      break;
    case CoverageChoice::Kind::kNone:
      out["alpha"] = "none";
      break;
    case CoverageChoice::Kind::kBand:
      out["alpha"] = source.coverage.band;
      break;
  }
  if (!source.bands.empty()) out["bands"] = source.bands;
  // A file that says all about itself is no more than its name.
  return out.size() == 1 ? out["file"] : out;
}

Json options_json(const LayerRequest& asked, const std::filesystem::path& folder) {
  Json out = Json::object();
  for (const auto& [name, value] : asked.options) {
    const channels::OptionInfo* const info = channels::kind_of(asked.channel).find_option(name);
    const bool is_file = info != nullptr && info->is_file;
    out[name] = is_file ? (folder / value).generic_string() : value;
  }
  return out;
}

Json expected_json(const ExpectedSamples& expected) {
  Json out = {{"type", sample_name(expected.type)}, {"bands", expected.bands}};
  if (expected.has_alpha) out["alpha"] = true;
  if (expected.nodata) out["nodata"] = *expected.nodata;
  return out;
}

}  // namespace

Area area_from_json(const json& value) {
  return {value.at("west").get<double>(), value.at("south").get<double>(), value.at("east").get<double>(), value.at("north").get<double>()};
}

Result<LayerRequest> layer_from_json(const json& value, const std::string& where) {
  LayerRequest layer;
  layer.name = value.at("name").get<std::string>();
  const channels::ChannelKind* const channel = channels::find_channel(value.at("channel").get<std::string>());
  if (channel == nullptr)
    return fail(ErrorCode::kInvalidData, where + "/channel: unknown channel '" + value.at("channel").get<std::string>() + "'; known are " +
                                             channels::channel_names());
  layer.channel = channel->type;
  if (value.contains("crs")) {
    VT_ASSIGN(layer.crs, crs_from(value["crs"].get<std::string>(), where + "/crs"));
  }
  std::size_t index = 0;
  for (const json& source : value.value("sources", json::array())) {
    VT_ASSIGN(SourceRequest request, source_from(source, where + "/sources/" + std::to_string(index++)));
    layer.sources.push_back(std::move(request));
  }
  if (value.contains("format")) {
    layer.format = format_from_name(value["format"].get<std::string>());
    if (!layer.format)
      return fail(ErrorCode::kInvalidData, where + "/format: unknown texel format '" + value["format"].get<std::string>() + "'");
  }
  layer.kernel = value.value("kernel", layer.kernel);
  const json options = value.value("options", json::object());  // items() refers to it
  for (const auto& [name, option] : options.items())
    layer.options[name] = option.is_string()    ? option.get<std::string>()
                          : option.is_boolean() ? (option.get<bool>() ? "yes" : "no")
                                                : option.dump();
  layer.compression = value.value("compression", layer.compression);
  if (value.contains("quality")) {
    const auto quality = encode::quality_from_name(value["quality"].get<std::string>());
    if (!quality) return fail(ErrorCode::kInvalidData, where + "/quality: unknown quality '" + value["quality"].get<std::string>() + "'");
    layer.quality = *quality;
  }
  layer.tile_texels = value.value("tile", layer.tile_texels);
  if (value.contains("gsd")) layer.gsd_m = value["gsd"].get<double>();
  if (value.contains("range")) layer.range = std::array<double, 2>{value["range"][0].get<double>(), value["range"][1].get<double>()};
  if (value.contains("resample")) {
    const auto method = resample::method_from_name(value["resample"].get<std::string>());
    if (!method) return fail(ErrorCode::kInvalidData, where + "/resample: unknown method '" + value["resample"].get<std::string>() + "'");
    layer.resample = *method;
  }
  if (value.contains("area")) layer.area = area_from_json(value["area"]);
  if (value.contains("expect")) {
    VT_ASSIGN(layer.expected, expected_from(value["expect"], where + "/expect"));
  }
  return layer;
}

Result<LayerRequest> request_from_json(const json& layer, const std::string& where) {
  VT_CHECK(check_against_layer_schema(layer, where));
  return layer_from_json(layer, where);
}

Result<Json> request_json(const LayerRequest& asked, const std::filesystem::path& folder) {
  Json out;
  out["name"] = asked.name;
  out["channel"] = channels::channel_name(asked.channel);
  VT_CHECK(put_crs(out, "crs", asked.crs));
  for (const SourceRequest& source : asked.sources) {
    VT_ASSIGN(Json one, source_json(source, folder));
    out["sources"].push_back(std::move(one));
  }
  if (asked.format) out["format"] = format_info(*asked.format).name;
  if (!asked.kernel.empty()) out["kernel"] = asked.kernel;
  out["quality"] = encode::quality_name(asked.quality);
  if (!asked.options.empty()) out["options"] = options_json(asked, folder);
  out["compression"] = asked.compression;
  out["tile"] = asked.tile_texels;
  if (asked.gsd_m) out["gsd"] = *asked.gsd_m;
  if (asked.area)
    out["area"] = {{"west", asked.area->west}, {"south", asked.area->south}, {"east", asked.area->east}, {"north", asked.area->north}};
  if (asked.range) out["range"] = *asked.range;
  if (asked.resample) out["resample"] = resample::method_name(*asked.resample);
  if (asked.expected) out["expect"] = expected_json(*asked.expected);
  return out;
}

}  // namespace vt::pipeline
