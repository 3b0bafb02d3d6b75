// What a store remembers of how its layers were asked for, and what `vtbuild update` and `vtinspect compare`
// make of it. Stores of older programs, which remember command lines, lie in tests/golden/recipes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "builder/pipeline/request/dataset_schema.h"
#include "tests/cli/program_run.h"
#include "tests/support/temp_folder.h"
#include "tools/vtbuild/recipe.h"

namespace vt::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class VtbuildRecipes : public testing::Test {
 protected:
  // A copy that may be written into: tiles/, list.txt, classes.json, SCENE.json, stores/.
  void SetUp() override {
    std::filesystem::copy(std::filesystem::path(VT_SCHEMAS) / "../tests/golden/recipes", folder_ / "data",
                          std::filesystem::copy_options::recursive);
  }
  Outcome run(const std::vector<std::string>& arguments, const std::string& from = "") {
    return run_program(VT_VTBUILD, arguments, from.empty() ? folder_.path() : folder_ / from);
  }
  void expect_built(const std::vector<std::string>& arguments, const std::string& from = "data") {
    std::vector<std::string> quiet = arguments;
    quiet.insert(quiet.end(), {"--progress", "none"});
    const Outcome outcome = run(quiet, from);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  // The two layers of the golden store, by the commands that it was made with; build_scene() likewise.
  void build_layers() {
    std::filesystem::remove(folder_ / "data/stores/layers.vts");
    expect_built({"layer", "tiles", "@list.txt", "-o", "stores/layers.vts", "--channel", "mask", "--crs", "EPSG:4326", "--extent",
                  "10,20,22,28", "--tile", "16", "--nodata", "7", "--inside", "1,2,3", "--name", "cover"});
    expect_built({"layer", "tiles/b.pgm", "-o", "stores/layers.vts", "--channel", "material", "--source-crs", "EPSG:4326", "--extent",
                  "10,20,22,28", "--tile", "16", "--classes", "classes.json", "--mixture", "2", "--name=-classes"});
  }
  void build_scene() {
    std::filesystem::remove(folder_ / "data/stores/scene.vts");
    expect_built({"dataset", "SCENE.json", "-o", "stores/scene.vts"});
  }
  json metadata_of(const std::string& store, const std::string& layer) {
    const Outcome outcome = run_program(VT_VTINSPECT, {"info", store, "--json"}, folder_.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const json document = json::parse(outcome.out, nullptr, false);
    for (const json& one : document["layers"])
      if (one["name"] == layer) return one["metadata"];
    ADD_FAILURE() << store << " has no layer " << layer;
    return {};
  }
  json recipe_of(const std::string& store, const std::string& layer) { return metadata_of(store, layer)["recipe"]; }
  // What an update of the store reports of each layer.
  json updated(const std::string& store, const std::string& from = "", const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"update", store, "--progress", "none", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments, from);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json::parse(outcome.out, nullptr, false)["layers"];
  }
  void expect_nothing_changed(const json& layers, std::size_t count) {
    ASSERT_EQ(layers.size(), count);
    for (const json& layer : layers) {
      EXPECT_EQ(layer["blocks"]["checked"], 1) << layer;
      EXPECT_EQ(layer["blocks"]["changed"], 0) << layer;
    }
  }
  void change_tile(const std::string& tile) {
    std::fstream file(folder_ / tile, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(40);
    file.put('\x02');
    file.put('\x02');
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name, std::ios::binary) << text; }

  TempFolder folder_;
};

TEST_F(VtbuildRecipes, StoresOfOlderProgramsAreUpdatedFromAnywhere) {
  ASSERT_TRUE(recipe_of("data/stores/layers.vts", "cover").contains("arguments"));
  std::filesystem::create_directory(folder_ / "elsewhere");
  expect_nothing_changed(updated("data/stores/layers.vts"), 2);
  expect_nothing_changed(updated("../data/stores/scene.vts", "elsewhere"), 2);
  expect_nothing_changed(updated("layers.vts", "data/stores"), 2);
  expect_nothing_changed(updated((folder_ / "data/stores/scene.vts").string(), "elsewhere"), 2);

  change_tile("data/tiles/b.pgm");
  for (const char* store : {"data/stores/layers.vts", "data/stores/scene.vts"}) {
    const json layers = updated(store);
    ASSERT_EQ(layers.size(), 2U) << store;
    for (const json& layer : layers) EXPECT_EQ(layer["blocks"]["changed"], 1) << layer;
  }
  // What is built again is remembered as a request.
  EXPECT_EQ(recipe_of("data/stores/layers.vts", "cover")["request"]["sources"][0]["file"], "tiles");
  EXPECT_EQ(recipe_of("data/stores/scene.vts", "cover")["scene"], "SCENE.json");
  for (const char* layer : {"cover", "-classes"}) {
    EXPECT_FALSE(recipe_of("data/stores/layers.vts", layer).contains("arguments"));
    EXPECT_EQ(recipe_of("data/stores/layers.vts", layer)["folder"], "..");
  }
  expect_nothing_changed(updated("data/stores/layers.vts"), 2);
}

TEST_F(VtbuildRecipes, OlderProgramsAskedForTheSame) {
  const std::vector<std::string> names = {"cover", "-classes"};
  std::vector<json> before;
  for (const std::string& name : names) before.push_back(metadata_of("data/stores/layers.vts", name)["settings"]);
  build_layers();
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(metadata_of("data/stores/layers.vts", names[i])["settings"], before[i]);
}

TEST_F(VtbuildRecipes, ALayerRemembersItsRequest) {
  build_layers();
  build_scene();
  for (const auto& [store, layer] : {std::pair("layers", "cover"), {"layers", "-classes"}, {"scene", "cover"}, {"scene", "classes"}}) {
    const json recipe = recipe_of(std::string("data/stores/") + store + ".vts", layer);
    EXPECT_EQ(recipe["folder"], "..") << recipe;
    EXPECT_FALSE(recipe.contains("arguments")) << recipe;
    EXPECT_EQ(recipe.contains("scene"), std::string(store) == "scene") << recipe;
    const auto checked = pipeline::check_against_layer_schema(recipe["request"], "request");
    EXPECT_TRUE(checked.has_value()) << checked.error().message << recipe;
  }
  EXPECT_EQ(recipe_of("data/stores/layers.vts", "cover")["request"], json::parse(R"({"name": "cover", "channel": "mask", "crs": "EPSG:4326",
    "sources": [{"file": "tiles", "fallback_crs": "EPSG:4326", "extent": [10.0, 20.0, 22.0, 28.0], "nodata": 7.0},
                {"file": "@list.txt", "fallback_crs": "EPSG:4326", "extent": [10.0, 20.0, 22.0, 28.0], "nodata": 7.0}],
    "quality": "normal", "options": {"inside": "1,2,3"}, "compression": "zstd:3", "tile": 16})"));
}

TEST_F(VtbuildRecipes, StoreAndSourcesMoveTogetherAndFoldersAreReadAnew) {
  build_layers();
  std::filesystem::rename(folder_ / "data", folder_ / "moved");
  expect_nothing_changed(updated("moved/stores/layers.vts"), 2);
  std::filesystem::copy_file(folder_ / "moved/tiles/a.pgm", folder_ / "moved/tiles/c.pgm");
  const json layers = updated("moved/stores/layers.vts");
  EXPECT_EQ(layers[0]["blocks"]["changed"], 1) << "a new file lies in the folder";
  EXPECT_EQ(layers[1]["blocks"]["changed"], 0);
  // The sources alone have moved.
  std::filesystem::create_directory(folder_ / "far");
  for (const char* name : {"tiles", "list.txt", "classes.json"}) std::filesystem::rename(folder_ / "moved" / name, folder_ / "far" / name);
  EXPECT_EQ(run({"update", "moved/stores/layers.vts"}).exit_code, 2);
  expect_nothing_changed(updated("moved/stores/layers.vts", "", {"--folder", "far"}), 2);
  expect_nothing_changed(updated("../moved/stores/layers.vts", "far", {"--folder", "."}), 2);
  const Outcome nowhere = run({"update", "moved/stores/layers.vts", "--folder", "none"});
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, AllOf(HasSubstr("none: the store was built from sources relative to this folder"), HasSubstr("--folder")));
}

// A scene is read again, as it is now; what it said then is in the store as well.
TEST_F(VtbuildRecipes, ASceneIsReadAgain) {
  build_scene();
  const std::string cover = R"({"name": "cover", "channel": "mask", "tile": 16, "options": {"inside": "1,2,3"}, "sources": [
    {"file": "tiles", "crs": "EPSG:4326", "extent": [10, 20, 22, 28], "nodata": 7},
    {"file": "@list.txt", "extent": [22, 20, 34, 28], "crs": "EPSG:4326"},
    {"file": "tiles/b.pgm", "extent": [22, 20, 34, 28], "crs": "EPSG:4326"}]})";
  write("data/SCENE.json", R"({"format": "vt-scene", "version": 1, "name": "n", "crs": "EPSG:4326", "layers": [)" + cover + "]}");
  const json layers = updated("data/stores/scene.vts");
  ASSERT_EQ(layers.size(), 1U) << "the scene has one layer now";
  EXPECT_EQ(layers[0]["blocks"]["changed"], 1);
  EXPECT_EQ(recipe_of("data/stores/scene.vts", "cover")["request"]["sources"].size(), 3U);
  std::filesystem::remove(folder_ / "data/SCENE.json");
  const Outcome gone = run({"update", "data/stores/scene.vts"});
  EXPECT_EQ(gone.exit_code, 2);
  EXPECT_THAT(gone.err, HasSubstr("SCENE.json"));
}

TEST_F(VtbuildRecipes, ARasterIsComparedAsItsSourceWasReadWithoutTheScene) {
  build_scene();
  std::filesystem::remove(folder_ / "data/SCENE.json");
  for (const std::string from : {"data", "data/stores"}) {
    const std::string up = from == "data" ? "" : "../";
    const Outcome outcome =
        run_program(VT_VTINSPECT, {"compare", from == "data" ? "stores/scene.vts" : "scene.vts", up + "tiles/b.pgm", "--layer", "classes"},
                    folder_ / from);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  }
}

TEST_F(VtbuildRecipes, ARasterIsComparedAsAnOlderProgramReadIt) {
  for (const std::string store : {"layers", "scene"}) {
    const Outcome outcome =
        run_program(VT_VTINSPECT,
                    {"compare", "data/stores/" + store + ".vts", "data/tiles/b.pgm", "--layer", store == "scene" ? "classes" : "-classes"},
                    folder_.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  }
}

TEST_F(VtbuildRecipes, ADryRunSaysWhatAnUpdateWouldFind) {
  build_layers();
  const auto plan = [&] {
    const Outcome outcome = run({"update", "data/stores/layers.vts", "--dry-run", "--json"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const json document = json::parse(outcome.out, nullptr, false);
    EXPECT_EQ(schema_complaints("build-plan", document), "") << outcome.out;
    EXPECT_EQ(document["layers"].size(), 2U) << "one document for all layers";
    EXPECT_EQ(document["total"]["tiles"], document["layers"][0]["tiles"].get<int>() + document["layers"][1]["tiles"].get<int>());
    EXPECT_THAT(outcome.err, HasSubstr("reads no samples"));
    return document["warnings"].dump();
  };
  EXPECT_THAT(plan(), AllOf(HasSubstr("layer 'cover': by a look at a few pieces of each file its sources are as they were"),
                            HasSubstr("layer '-classes': by a look")));
  change_tile("data/tiles/b.pgm");
  std::filesystem::copy_file(folder_ / "data/tiles/a.pgm", folder_ / "data/tiles/c.pgm");
  EXPECT_THAT(plan(), AllOf(HasSubstr("(changed: b.pgm; new: c.pgm)"), HasSubstr("(changed: b.pgm)")));
  EXPECT_THAT(run({"update", "data/stores/layers.vts", "--dry-run"}).out, AllOf(HasSubstr("layer cover"), HasSubstr("layer -classes")));
}

TEST_F(VtbuildRecipes, ARefusalNamesTheSettingsThatDiffer) {
  build_layers();
  const Outcome outcome = run({"layer", "tiles", "@list.txt", "-o", "stores/layers.vts", "--channel", "mask", "--crs", "EPSG:4326",
                               "--extent", "10,20,22,28", "--tile", "32", "--nodata", "7", "--inside", "1,2", "--name", "cover"},
                              "data");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("built with other settings (--inside: 1,2,3 there, 1,2 here; --tile: 16 there, 32 here)"),
                                 HasSubstr("choose another --name")));
}

TEST_F(VtbuildRecipes, ARangeThatGoesDownwardsIsRefused) {
  const Outcome layer = run({"layer", "tiles/a.pgm", "-o", "x.vts", "--channel", "color", "--crs", "pixel", "--range", "9,0"}, "data");
  EXPECT_EQ(layer.exit_code, 1);
  EXPECT_THAT(layer.err, HasSubstr("--range is LOW,HIGH, and 9 does not lie below 0"));
  write("data/down.json", R"({"format": "vt-scene", "version": 1, "name": "n",
    "layers": [{"name": "c", "channel": "color", "sources": [{"file": "tiles/a.pgm", "crs": "pixel"}], "range": [9, 0]}]})");
  const Outcome scene = run({"dataset", "down.json", "-o", "x.vts"}, "data");
  EXPECT_EQ(scene.exit_code, 1);
  EXPECT_THAT(scene.err, HasSubstr("`range` is LOW,HIGH"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "data/x.vts"));
}

// Metadata may be anything.
TEST(Recipe, WhatIsNotUnderstoodIsRefused) {
  const auto read = [](const std::string& recipe) { return tools::read_recipe(R"({"recipe": )" + recipe + "}", "stores/a.vts"); };
  for (const char* recipe : {"null", "[]", "{}", R"({"folder": "."})", R"({"folder": 1, "scene": "s"})", R"({"folder": ".", "scene": 1})",
                             R"({"folder": ".", "request": 1})", R"({"folder": ".", "scene": 1, "request": {"name": "a"}})",
                             R"({"folder": ".", "request": {"name": "a", "channel": "color", "sources": ["a.tif"], "tile": 100}})",
                             R"({"folder": ".", "arguments": []})", R"({"folder": ".", "arguments": ["pack", "a.vts"]})",
                             R"({"folder": ".", "arguments": ["layer", 1]})",
                             R"({"folder": ".", "arguments": ["layer", "a.tif", "--channel=color", "--odd=1"]})",
                             R"({"folder": ".", "arguments": ["dataset"]})", R"({"arguments": ["dataset", "S.json"]})"}) {
    const auto refused = read(recipe);
    ASSERT_FALSE(refused.has_value()) << recipe;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidData) << recipe << refused.error().message;
    EXPECT_THAT(refused.error().message, HasSubstr("stores/a.vts"));
  }
  EXPECT_FALSE(tools::read_recipe("no JSON", "a.vts").has_value());
}

TEST(Recipe, OfEveryKindIsRead) {
  const auto read = [](const std::string& recipe) { return tools::read_recipe(R"({"recipe": )" + recipe + "}", "stores/a.vts").value(); };
  const tools::Recipe command =
      read(R"({"folder": "../in", "arguments": ["layer", "--channel=color", "--alpha=associated,2", "--", "-a.tif"]})");
  EXPECT_EQ(command.folder, "in");
  EXPECT_EQ(command.asked->sources[0].path, "-a.tif");
  EXPECT_EQ(command.asked->sources[0].coverage.band, 2);
  EXPECT_EQ(command.asked->options.at("alpha"), "associated");
  EXPECT_EQ(read(R"({"folder": "..", "arguments": ["dataset", "--", "-S.json"]})").scene, "-S.json");
  EXPECT_EQ(read(R"({"folder": "..", "scene": "S.json"})").folder, "") << "the current folder";
  EXPECT_FALSE(read(R"({"folder": "..", "scene": "S.json", "request": {"of": "a later version"}})").asked.has_value());
  EXPECT_EQ(read(R"({"folder": "/in", "request": {"name": "a", "channel": "color", "sources": ["a.tif"]}})").folder, "/in");
}

TEST(Recipe, ALongRequestIsLeftToItsScene) {
  pipeline::LayerRequest asked;
  asked.name = "layer";
  asked.sources.resize(2000, {.path = std::string(100, 'a')});
  EXPECT_TRUE(tools::scene_recipe_json("S.json", asked, {}, "a.vts").value().contains("request"));
  asked.sources.resize(3000, {.path = std::string(100, 'a')});
  const auto recipe = tools::scene_recipe_json("S.json", asked, {}, "a.vts").value();
  EXPECT_FALSE(recipe.contains("request"));
  EXPECT_EQ(recipe["scene"], "S.json");
  EXPECT_EQ(tools::recipe_json(asked, {}, "a.vts").value()["request"]["sources"].size(), 3000U) << "without a scene it is all there is";
}

// ---- Messages: what a library says, and what its user reads ----

TEST_F(VtbuildRecipes, MessagesNameFlagsOnTheCommandLineAndKeysInAScene) {
  write("data/rgb.ppm", "P6 4 4 255\n" + std::string(48, '\x10'));
  const auto refusal = [&](const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments, "data");
    EXPECT_NE(outcome.exit_code, 0);
    return outcome.err;
  };
  const auto scene = [&](const std::string& layer) {
    write("data/S.json", R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [)" + layer + "]}");
    return refusal({"dataset", "S.json", "-o", "x.vts"});
  };
  EXPECT_THAT(refusal({"layer", "rgb.ppm", "-o", "x.vts", "--channel", "elevation", "--crs", "pixel"}),
              AllOf(HasSubstr("say which with --bands, for example --bands 1"), Not(HasSubstr("`"))));
  EXPECT_THAT(scene(R"({"name": "e", "channel": "elevation", "sources": [{"file": "rgb.ppm", "crs": "pixel"}]})"),
              AllOf(HasSubstr("say which with `bands`, for example `bands` 1"), Not(HasSubstr("--bands"))));
  EXPECT_THAT(refusal({"layer", "rgb.ppm", "-o", "x.vts", "--channel", "color"}),
              AllOf(HasSubstr("--crs EPSG:4326"), HasSubstr("--extent WEST,SOUTH,EAST,NORTH")));
  EXPECT_THAT(scene(R"({"name": "c", "channel": "color", "sources": ["rgb.ppm"]})"),
              AllOf(HasSubstr("`crs` EPSG:4326"), HasSubstr("`extent` WEST,SOUTH,EAST,NORTH"), Not(HasSubstr("--"))));
  EXPECT_THAT(refusal({"layer", "tiles/a.pgm", "-o", "x.vts", "--channel", "sensor", "--quantity", "temperature", "--crs", "pixel"}),
              HasSubstr("--band LOW,HIGH"));
  EXPECT_THAT(scene(R"({"name": "s", "channel": "sensor", "sources": [{"file": "tiles/a.pgm", "crs": "pixel"}],
                        "options": {"quantity": "temperature"}})"),
              HasSubstr("`band` LOW,HIGH"));
  // A key that is not called like its flag.
  EXPECT_THAT(scene(R"({"name": "m", "channel": "mask", "sources": [{"file": "tiles/a.pgm", "source_crs": "EPSG:4326",
                        "extent": [400000, 0, 400010, 10]}]})"),
              HasSubstr("with `source_crs` EPSG:nnnn"));
  EXPECT_THAT(
      refusal({"layer", "tiles/a.pgm", "-o", "x.vts", "--channel", "mask", "--source-crs", "EPSG:4326", "--extent", "400000,0,400010,10"}),
      HasSubstr("with --source-crs EPSG:nnnn"));
  // What is an option of both commands.
  write("data/S.json", R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [
    {"name": "m", "channel": "mask", "options": {"inside": "1"}, "sources": [{"file": "tiles/a.pgm", "crs": "pixel"}]}]})");
  EXPECT_THAT(refusal({"dataset", "S.json", "-o", "x.vts", "--memory", "1M"}), HasSubstr("it needs --memory "));
}

TEST_F(VtbuildRecipes, AMisspelledOptionPointsToTheHelpOfItsCommand) {
  const auto err = [&](const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments, "data");
    EXPECT_EQ(outcome.exit_code, 1);
    return outcome.err;
  };
  EXPECT_THAT(err({"layer", "tiles/a.pgm", "-o", "x.vts", "--channel", "mask", "--bandz", "1"}),
              AllOf(HasSubstr("--bandz"), HasSubstr("Run `vtbuild layer --help`")));
  EXPECT_THAT(err({"update", "a.vts", "--thread", "1"}), HasSubstr("Run `vtbuild update --help`"));
  EXPECT_THAT(err({"layers"}), HasSubstr("Run `vtbuild --help`"));
}

}  // namespace
}  // namespace vt::test
