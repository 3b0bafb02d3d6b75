#include "builder/pipeline/request/scene_file.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "builder/pipeline/request/embedded_schemas.h"
#include "builder/pipeline/request/input_list.h"
#include "builder/pipeline/request/option_files.h"
#include "builder/text/json_text.h"
#include "builder/text/text_file.h"

namespace vt::pipeline {
namespace {

using nlohmann::json;

// "[layers][0][channel]" of the validator as "/layers/0/channel".
std::string json_pointer(const std::vector<std::string>& context) {
  std::string pointer;
  for (const std::string& part : context) {
    if (part == "<root>") continue;
    pointer += '/';
    for (char c : part)
      if (c != '[' && c != ']') pointer += c;
  }
  return pointer.empty() ? "/" : pointer;
}

Area area_from(const json& value) {
  return {value.at("west").get<double>(), value.at("south").get<double>(), value.at("east").get<double>(), value.at("north").get<double>()};
}

// The coordinate reference system that `text` names; `where` is its place in the file.
Result<geo::Crs> crs_from(const std::string& text, const std::string& where) {
  auto crs = geo::Crs::from_text(text);
  if (!crs) return fail(crs.error().code, where + ": " + crs.error().message);
  return crs;
}

// A source names one raster, or a folder or a list of them that are all read in the same way.
Result<std::vector<SourceRequest>> sources_from(const json& value, const std::filesystem::path& folder, const std::string& where) {
  SourceRequest source;
  std::string input;
  if (value.is_string()) {
    input = value.get<std::string>();
  } else {
    input = value.at("file").get<std::string>();
    if (value.contains("crs")) {
      VT_ASSIGN(source.stated_crs, crs_from(value["crs"].get<std::string>(), where + "/crs"));
    }
    if (value.contains("source_crs")) {
      VT_ASSIGN(source.crs, crs_from(value["source_crs"].get<std::string>(), where + "/source_crs"));
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
  }
  auto files = expand_input(input, folder);
  if (!files) return fail(files.error().code, where + ": " + files.error().message);
  std::vector<SourceRequest> sources(files->size(), source);
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i].path = std::move((*files)[i]);
  return sources;
}

std::optional<SampleType> sample_type_from_name(const std::string& name) {
  for (const SampleType type : {SampleType::kUint8, SampleType::kInt8, SampleType::kUint16, SampleType::kInt16, SampleType::kUint32,
                                SampleType::kInt32, SampleType::kFloat32, SampleType::kFloat64})
    if (name == sample_name(type)) return type;
  return std::nullopt;
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

Result<LayerRequest> layer_from(const json& value, const Scene& scene, const std::filesystem::path& folder, const std::string& where) {
  LayerRequest layer;
  layer.name = value.at("name").get<std::string>();
  const channels::ChannelKind* const channel = channels::find_channel(value.at("channel").get<std::string>());
  if (!channel) return fail(ErrorCode::kInvalidData, where + "/channel: unknown channel '" + value.at("channel").get<std::string>() + "'");
  layer.channel = channel->type;
  std::size_t index = 0;
  for (const json& source : value.value("sources", json::array())) {
    VT_ASSIGN(std::vector<SourceRequest> requests, sources_from(source, folder, where + "/sources/" + std::to_string(index++)));
    std::ranges::move(requests, std::back_inserter(layer.sources));
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
  const auto loaded = load_option_files(layer.channel, folder, layer.options);
  if (!loaded) return fail(loaded.error().code, where + "/options: " + loaded.error().message);
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
  if (value.contains("area")) layer.area = area_from(value["area"]);
  if (value.contains("expect")) {
    VT_ASSIGN(layer.expected, expected_from(value["expect"], where + "/expect"));
    // A layer that is planned before its sources are there covers the dataset.
    if (!layer.area) layer.area = scene.area;
  }
  layer.crs = scene.crs;
  return layer;
}

}  // namespace

Result<void> check_against_dataset_schema(const json& document, const std::string& where) {
  try {
    const json schema_document = json::parse(kDatasetSchema);
    valijson::Schema schema;
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_document), schema);
    valijson::ValidationResults results;
    valijson::Validator validator;
    if (validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results)) return {};
    // The deepest place is the one that a person can act on; outer ones only repeat that something inside is wrong.
    valijson::ValidationResults::Error error;
    valijson::ValidationResults::Error deepest;
    while (results.popError(error))
      if (error.context.size() >= deepest.context.size()) deepest = error;
    return fail(ErrorCode::kInvalidData, where + ": at " + json_pointer(deepest.context) + ": " + deepest.description +
                                             " See schemas/dataset.schema.json for what is accepted.");
  } catch (const std::exception& e) {
    return fail(ErrorCode::kInternal, where + ": the dataset schema could not be applied: " + e.what());
  }
}

Result<Scene> read_scene(const std::filesystem::path& path) {
  VT_ASSIGN(const std::string content, text::read_text_file(path, text::kMaxJsonBytes));
  auto parsed = text::parse_json(content);
  if (!parsed) return fail(parsed.error().code, path.string() + ": " + parsed.error().message);
  const json document = std::move(*parsed);
  VT_CHECK(check_against_dataset_schema(document, path.string()));

  Scene scene;
  scene.name = document.value("name", path.stem().string());
  if (document.contains("crs")) {
    VT_ASSIGN(scene.crs, crs_from(document["crs"].get<std::string>(), path.string() + ": at /crs"));
  }
  if (document.contains("area")) scene.area = area_from(document["area"]);
  std::size_t index = 0;
  for (const json& layer : document.at("layers")) {
    const std::string where = path.string() + ": at /layers/" + std::to_string(index++);
    VT_ASSIGN(LayerRequest request, layer_from(layer, scene, path.parent_path(), where));
    for (const LayerRequest& other : scene.layers)
      if (other.name == request.name) return fail(ErrorCode::kInvalidData, where + "/name: '" + request.name + "' is used twice");
    scene.layers.push_back(std::move(request));
  }
  return scene;
}

}  // namespace vt::pipeline
