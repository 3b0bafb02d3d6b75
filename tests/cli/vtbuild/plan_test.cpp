// vtbuild --dry-run, and the inputs that it shares with a build: folders, areas, descriptions of what is not
// there yet.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/program_run.h"
#include "tests/support/temp_folder.h"

namespace vt::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class VtbuildPlanTest : public testing::Test {
 protected:
  Outcome run(const std::vector<std::string>& arguments) { return run_program(VT_VTBUILD, arguments, folder_.path()); }
  // The document of a dry run, checked against its schema.
  json plan(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"-o", "x.vts", "--dry-run", "--json"});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    errors_ = outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.vts")) << "a dry run builds nothing";
    json document = json::parse(outcome.out);
    EXPECT_EQ(schema_complaints("build-plan", document), "");
    return document;
  }
  void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::vector<std::string>& phrases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    for (const std::string& phrase : phrases) EXPECT_THAT(outcome.err, HasSubstr(phrase));
  }
  void make_scene() { ASSERT_EQ(run({"sample", "-o", "scene", "--size", "512", "--progress", "none"}).exit_code, 0); }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name, std::ios::binary) << text; }

  TempFolder folder_;
  std::string errors_;
};

TEST_F(VtbuildPlanTest, WhatIsCountedIsWhatIsBuilt) {
  make_scene();
  const json document = plan({"dataset", "scene/SCENE.json", "--threads", "3", "--rate", "50"});
  EXPECT_EQ(document["threads"], 3);
  const json& memory = document["layers"][0]["memory"];
  const auto bytes = [&](const char* name) { return memory[name].get<std::int64_t>(); };
  EXPECT_EQ(bytes("total"), bytes("program") + bytes("sources") + bytes("store") + 3 * bytes("worker"));
  EXPECT_LE(bytes("total"), document["memory_limit_bytes"].get<std::int64_t>());

  ASSERT_EQ(run({"dataset", "scene/SCENE.json", "-o", "scene.vts", "--progress", "none"}).exit_code, 0);
  const json built = json::parse(run_program(VT_VTINSPECT, {"info", "scene.vts", "--json"}, folder_.path()).out);
  int compared = 0;
  for (const json& layer : document["layers"]) {
    EXPECT_EQ(layer["estimate"]["megatexels_per_second"], 50.0);
    EXPECT_EQ(layer["sources"]["are_there"], true);
    // A layer is counted with its parts.
    std::int64_t tiles = 0;
    for (const json& stored : built["layers"]) {
      const std::string name = stored["name"].get<std::string>();
      const bool is_of_layer = name == layer["name"] || name.starts_with(layer["name"].get<std::string>() + "/");
      if (stored["role"] == "texture" && is_of_layer) tiles += stored["tiles"].get<std::int64_t>();
    }
    EXPECT_EQ(tiles, layer["tiles"]) << layer["name"];
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

TEST_F(VtbuildPlanTest, ACountryIsPlannedBeforeItsSourcesExist) {
  write("country.json", R"({"format": "vt-scene", "version": 1, "name": "country", "crs": "EPSG:32633",
    "area": {"west": 100000, "south": 5000000, "east": 1000000, "north": 5700000},
    "layers": [{"name": "color", "channel": "color", "gsd": 0.8, "sources": ["west.tif", "east.tif"], "expect": {"type": "uint8", "bands": 3}},
               {"name": "elevation", "channel": "elevation", "gsd": 0.8, "expect": {"type": "int16", "bands": 1, "nodata": -32768}}]})");
  const json document = plan({"dataset", "country.json"});
  for (const json& layer : document["layers"]) {
    EXPECT_EQ(layer["width"], 1125000);
    EXPECT_EQ(layer["height"], 875000);
    EXPECT_EQ(layer["tiles"], 20032168);
    EXPECT_EQ(layer["sources"]["are_there"], false);
  }
  EXPECT_THAT(run({"dataset", "country.json", "-o", "x.vts", "--dry-run"}).out,
              AllOf(HasSubstr("20032168 tiles"), HasSubstr("time"), HasSubstr("index"), HasSubstr("each thread")));
  expect_failure({"dataset", "country.json", "-o", "x.vts"}, 2, {"2 of 2 sources", "west.tif", "east.tif"});
}

// More than one store holds, and more than this much memory can build: the plan is shown all the same, and
// says both.
TEST_F(VtbuildPlanTest, TheEarthAtHalfAMetreIsPlanned) {
  write("earth.json", R"({"format": "vt-scene", "version": 1, "name": "earth", "crs": "EPSG:4326",
    "area": {"west": -180, "south": -90, "east": 180, "north": 90},
    "layers": [{"name": "color", "channel": "color", "gsd": 0.5, "expect": {"type": "uint8", "bands": 3}}]})");
  const json document = plan({"dataset", "earth.json"});
  EXPECT_EQ(document["layers"][0]["width"], 80150034) << "2 pi a / 0.5 m along the equator";
  EXPECT_EQ(document["layers"][0]["levels"].size(), 20U);
  EXPECT_THAT(errors_, AllOf(HasSubstr("one store can hold"), HasSubstr("more than --memory")));
  EXPECT_EQ(document["warnings"].size(), 3U);
}

TEST_F(VtbuildPlanTest, AFolderAnAreaAndAMethod) {
  make_scene();
  std::filesystem::create_directory(folder_ / "tiles");
  std::filesystem::rename(folder_ / "scene/imagery.tif", folder_ / "tiles/imagery.tif");
  const json whole = plan({"layer", "tiles/", "--channel", "color"})["layers"][0];
  const auto edge = [&](const char* name) { return whole["extent"][name].get<double>(); };
  const json area{edge("west"), edge("south"), (edge("west") + edge("east")) / 2, edge("north")};
  const std::string numbers = area.dump();  // with as many digits as it takes
  const json half = plan(
      {"layer", "tiles/", "--channel", "color", "--area=" + numbers.substr(1, numbers.size() - 2), "--resample", "nearest"})["layers"][0];
  EXPECT_EQ(half["width"], 256);
  EXPECT_EQ(half["height"], 512);
  EXPECT_EQ(half["resample"], "nearest");
  expect_failure({"layer", "tiles/", "-o", "x.vts", "--channel", "color", "--resample", "cubic"}, 1, {"nearest or bilinear"});
  expect_failure({"layer", "tiles/", "-o", "x.vts", "--channel", "color", "--area", "3,2,1,0"}, 1, {"--area"});
}

}  // namespace
}  // namespace vt::test
