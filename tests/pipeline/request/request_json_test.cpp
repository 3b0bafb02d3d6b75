// A request that is written is read as what it was, and every one that is written follows the schema.
#include "builder/pipeline/request/request_json.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/request/dataset_schema.h"
#include "builder/pipeline/request/expand_request.h"
#include "builder/pyramid/halving_kernel.h"
#include "tests/support/temp_folder.h"

namespace vt::pipeline {
namespace {

using nlohmann::json;

geo::Crs crs(int epsg) { return geo::Crs::from_epsg(epsg).value(); }

LayerRequest plain_request() {
  LayerRequest request;
  request.name = "layer";
  request.sources = {{.path = "a.tif"}};
  return request;
}

// Every member is something else than it is by itself.
LayerRequest full_request() {
  LayerRequest request;
  request.name = "Größe 1/x";
  request.channel = ChannelType::kElevation;
  SourceRequest source;
  source.path = "../tiles";
  source.crs = crs(32633);
  source.stated_crs = geo::Crs();
  source.fallback_crs = crs(3857);
  source.extent = Area{179.5, -0.1, -179.5, 1e-9};
  source.nodata = {255, 255, 252.5};
  source.bands = {3, 2, 1};
  source.coverage = {.kind = CoverageChoice::Kind::kBand, .band = 4};
  request.sources = {
      source, {.path = "@list.txt", .nodata = {-32768}, .coverage = {.kind = CoverageChoice::Kind::kNone}}, {.path = "/b.tif"}};
  request.format = TexelFormat::kR16;
  request.options = {{"quantum", "0.1"}, {"bounds", "yes"}};
  request.kernel = "point";
  request.quality = encode::Quality::kBest;
  request.compression = "zstd:19";
  request.tile_texels = 4096;
  request.gsd_m = 0.1;
  request.crs = crs(4326);
  request.area = Area{170.0, -1.5, -170.0, 1.0 / 3.0};
  request.range = {{-500.25, 1e300}};
  request.resample = resample::Method::kNearest;
  request.expected = ExpectedSamples{.type = SampleType::kFloat64, .bands = 2, .has_alpha = true, .nodata = -1e-30};
  return request;
}

void expect_same_crs(const std::optional<geo::Crs>& a, const std::optional<geo::Crs>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (!a) return;
  EXPECT_EQ(a->text(), b->text());
}

void expect_same(const LayerRequest& a, const LayerRequest& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.channel, b.channel);
  ASSERT_EQ(a.sources.size(), b.sources.size());
  for (std::size_t i = 0; i < a.sources.size(); ++i) {
    const SourceRequest& x = a.sources[i];
    const SourceRequest& y = b.sources[i];
    EXPECT_EQ(x.path, y.path);
    expect_same_crs(x.crs, y.crs);
    expect_same_crs(x.stated_crs, y.stated_crs);
    expect_same_crs(x.fallback_crs, y.fallback_crs);
    EXPECT_EQ(x.extent, y.extent);
    EXPECT_EQ(x.nodata, y.nodata);
    EXPECT_EQ(x.bands, y.bands);
    EXPECT_EQ(x.coverage, y.coverage);
  }
  EXPECT_EQ(a.format, b.format);
  EXPECT_EQ(a.options, b.options);
  EXPECT_EQ(a.kernel, b.kernel);
  EXPECT_EQ(a.quality, b.quality);
  EXPECT_EQ(a.compression, b.compression);
  EXPECT_EQ(a.tile_texels, b.tile_texels);
  EXPECT_EQ(a.gsd_m, b.gsd_m);
  expect_same_crs(a.crs, b.crs);
  EXPECT_EQ(a.area, b.area);
  EXPECT_EQ(a.range, b.range);
  EXPECT_EQ(a.resample, b.resample);
  ASSERT_EQ(a.expected.has_value(), b.expected.has_value());
  if (!a.expected) return;
  EXPECT_EQ(a.expected->type, b.expected->type);
  EXPECT_EQ(a.expected->bands, b.expected->bands);
  EXPECT_EQ(a.expected->has_alpha, b.expected->has_alpha);
  EXPECT_EQ(a.expected->nodata, b.expected->nodata);
}

// As text, as it lies in a store.
json written(const LayerRequest& request, const std::filesystem::path& folder = {}) {
  const auto out = request_json(request, folder);
  EXPECT_TRUE(out.has_value()) << out.error().message;
  return json::parse(out->dump());
}

void expect_kept(const LayerRequest& request) {
  const json out = written(request);
  const auto back = request_from_json(out, "request");
  ASSERT_TRUE(back.has_value()) << back.error().message << out;
  expect_same(*back, request);
  EXPECT_EQ(written(*back), out);
}

TEST(RequestJson, IsReadAsItWasWritten) {
  expect_kept(plain_request());
  expect_kept(full_request());
  LayerRequest unsourced = full_request();
  unsourced.sources.clear();
  expect_kept(unsourced);
}

// Whoever adds a property to the schema adds it to the writer.
TEST(RequestJson, WritesAllThatTheSchemaKnows) {
  std::ifstream file(VT_SCHEMAS "/dataset.schema.json");
  const json schema = json::parse(file);
  const auto keys = [](const json& object) {
    std::set<std::string> names;
    for (const auto& [name, value] : object.items()) names.insert(name);
    return names;
  };
  const json out = written(full_request());
  const json& definitions = schema["definitions"];
  EXPECT_EQ(keys(out), keys(definitions["layer"]["properties"]));
  EXPECT_EQ(keys(out["sources"][0]), keys(definitions["source"]["properties"]));
  EXPECT_EQ(keys(out["expect"]), keys(definitions["layer"]["properties"]["expect"]["properties"]));
  EXPECT_EQ(out["sources"][2], "/b.tif") << "a file that says all about itself";
}

TEST(RequestJson, KeepsEveryMemberOfEveryClosedSet) {
  for (const channels::ChannelKind* const kind : channels::all_channels()) {
    LayerRequest request = plain_request();
    request.channel = kind->type;
    for (const channels::OptionInfo& option : kind->options) request.options[std::string(option.name)] = "x-" + std::string(option.name);
    expect_kept(request);
  }
  for (std::uint16_t number = 0; number < 256; ++number) {
    LayerRequest request = plain_request();
    request.format = format_from_number(number);
    // Opaque formats are those of a builder's own state.
    if (request.format && format_info(*request.format).samples != SampleKind::kOpaque) expect_kept(request);
  }
  for (const pyramid::HalvingKernel& kernel : pyramid::all_kernels()) {
    LayerRequest request = plain_request();
    request.kernel = kernel.name;
    expect_kept(request);
  }
  for (const std::string_view quality : encode::kQualityNames) {
    LayerRequest request = plain_request();
    request.quality = *encode::quality_from_name(quality);
    expect_kept(request);
  }
  for (const resample::Method method : {resample::Method::kNearest, resample::Method::kBilinear}) {
    LayerRequest request = plain_request();
    request.resample = method;
    expect_kept(request);
  }
  for (const SampleType type : kSampleTypes) {
    LayerRequest request = full_request();
    request.expected->type = type;
    expect_kept(request);
  }
  for (const CoverageChoice::Kind kind : {CoverageChoice::Kind::kAuto, CoverageChoice::Kind::kNone, CoverageChoice::Kind::kBand}) {
    LayerRequest request = plain_request();
    request.sources.front().coverage = {.kind = kind, .band = kind == CoverageChoice::Kind::kBand ? 4 : 0};
    expect_kept(request);
  }
  for (int texels = 4; texels <= 4096; texels *= 2) {
    LayerRequest request = plain_request();
    request.tile_texels = texels;
    expect_kept(request);
  }
}

TEST(RequestJson, AFolderIsPutBeforeRelativePathsAlone) {
  LayerRequest request = plain_request();
  request.channel = ChannelType::kMaterial;
  request.options = {{"classes", "classes.json"}, {"mixture", "2"}};
  request.sources = {{.path = "a.tif"}, {.path = "@lists/l.txt"}, {.path = "@/abs.txt"}, {.path = "/abs.tif"}, {.path = "../b"}};
  const json out = written(request, "scene");
  EXPECT_EQ(out["sources"], json::parse(R"(["scene/a.tif", "@scene/lists/l.txt", "@/abs.txt", "/abs.tif", "scene/../b"])"));
  EXPECT_EQ(out["options"], json::parse(R"({"classes": "scene/classes.json", "mixture": "2"})"));
  EXPECT_EQ(written(plain_request(), "@odd")["sources"][0], "./@odd/a.tif") << "a folder makes no list";
}

TEST(RequestJson, ACrsWithoutACodeIsRefused) {
  LayerRequest request = plain_request();
  geo::CrsDefinition definition = crs(32633).definition();
  definition.epsg = 0;
  request.crs = geo::Crs(definition);
  const auto refused = request_json(request);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
}

TEST(RequestJson, WhatDoesNotFollowTheSchemaIsRefusedByItsPlace) {
  json out = written(plain_request());
  out["tile"] = 100;
  const auto refused = request_from_json(out, "the request");
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(refused.error().message.find("the request: at /tile"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(request_from_json(json("text"), "the request").has_value());
  EXPECT_FALSE(request_from_json(json(), "the request").has_value());
}

TEST(ExpandRequest, ReadsFoldersListsAndFilesOfOptions) {
  const test::TempFolder folder;
  std::filesystem::create_directory(folder / "tiles");
  for (const char* name : {"tiles/b.tif", "tiles/a.tif"}) std::ofstream(folder / name) << "x";
  std::ofstream(folder / "list.txt") << "z.tif\n";
  std::ofstream(folder / "classes.json") << "[]";
  LayerRequest asked = plain_request();
  asked.channel = ChannelType::kMaterial;
  asked.sources = {{.path = "tiles", .nodata = {3}}, {.path = "@list.txt"}};
  asked.options = {{"classes", "classes.json"}};
  const auto request = expand_request(asked, folder.path());
  ASSERT_TRUE(request.has_value()) << request.error().message;
  ASSERT_EQ(request->sources.size(), 3U);
  EXPECT_EQ(request->sources[0].path, folder / "tiles/a.tif");
  EXPECT_EQ(request->sources[1].nodata, std::vector{3.0});
  EXPECT_EQ(request->sources[2].path, folder / "z.tif");
  EXPECT_EQ(request->options.at("classes"), "[]");
  asked.sources.push_back({.path = "@none.txt"});
  const auto refused = expand_request(asked, folder.path(), "SCENE.json: at /layers/0");
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().message.find("SCENE.json: at /layers/0/sources/2: "), 0U) << refused.error().message;
}

TEST(CheckRange, GoesUpwards) {
  LayerRequest request = plain_request();
  EXPECT_TRUE(check_range(request).has_value());
  request.range = {{0.0, 1.0}};
  EXPECT_TRUE(check_range(request).has_value());
  for (const double high : {0.0, -1.0}) {
    request.range = {{0.0, high}};
    ASSERT_FALSE(check_range(request).has_value());
    EXPECT_EQ(check_range(request).error().code, ErrorCode::kUsage);
    EXPECT_NE(check_range(request).error().message.find("`range` is LOW,HIGH"), std::string::npos);
  }
}

}  // namespace
}  // namespace vt::pipeline
