#include "builder/pipeline/request/scene_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace vt::pipeline {
namespace {

class SceneFile : public testing::Test {
 protected:
  Result<Scene> read(const std::string& text) {
    std::ofstream(folder_ / "SCENE.json") << text;
    return read_scene(folder_ / "SCENE.json");
  }
  void expect_refused(const std::string& text, const std::string& place) {
    const auto scene = read(text);
    ASSERT_FALSE(scene.has_value()) << text;
    EXPECT_EQ(scene.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(scene.error().message.find(place), std::string::npos) << scene.error().message;
    EXPECT_NE(scene.error().message.find("SCENE.json"), std::string::npos) << scene.error().message;
  }
  test::TempFolder folder_;
};

TEST_F(SceneFile, GivesBackWhatItSays) {
  const auto scene = read(R"({"format": "vt-scene", "version": 1, "name": "n", "crs": "EPSG:4326",
    "area": {"west": 1, "south": 2, "east": 3, "north": 4},
    "layers": [{"name": "c", "channel": "color", "sources": ["a.tif", {"file": "b.png", "crs": "EPSG:3857", "extent": [1, 2, 3, 4], "nodata": 7, "bands": [3, 2, 1]},
                {"file": "c.tif", "source_crs": "EPSG:32633"}],
                "format": "bc1", "kernel": "box", "compression": "zstd:9", "tile": 128, "gsd": 0.5},
               {"name": "e", "channel": "elevation", "sources": ["e.tif"]}]})");
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_EQ(scene->name, "n");
  EXPECT_EQ(scene->crs->definition().epsg, 4326);
  EXPECT_EQ(scene->area, (Area{1, 2, 3, 4}));
  ASSERT_EQ(scene->layers.size(), 2U);
  const LayerRequest& color = scene->layers[0];
  EXPECT_EQ(color.sources[0].path, folder_ / "a.tif");
  EXPECT_EQ(color.sources[1].path, folder_ / "b.png");
  EXPECT_EQ(color.sources[1].stated_crs->definition().epsg, 3857);
  EXPECT_FALSE(color.sources[1].crs.has_value()) << "only source_crs overrules the file";
  EXPECT_EQ(color.sources[2].crs->definition().epsg, 32633);
  EXPECT_EQ(color.sources[1].extent, (Area{1, 2, 3, 4}));
  EXPECT_EQ(color.sources[1].nodata, std::vector{7.0});
  EXPECT_EQ(color.sources[1].bands, (std::vector<int>{3, 2, 1}));
  EXPECT_EQ(color.format, TexelFormat::kBc1);
  EXPECT_EQ(color.kernel, "box");
  EXPECT_EQ(color.compression, "zstd:9");
  EXPECT_EQ(color.tile_texels, 128);
  EXPECT_EQ(color.gsd_m, 0.5);
  EXPECT_EQ(scene->layers[1].channel, ChannelType::kElevation);
  EXPECT_FALSE(scene->layers[1].format.has_value());
}

TEST_F(SceneFile, OptionsAreTextAndFilesTheirContent) {
  std::ofstream(folder_ / "classes.json") << "[]";
  const auto scene = read(R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [
    {"name": "m", "channel": "material", "sources": ["m.tif"], "options": {"mixture": 3, "classes": "classes.json"}},
    {"name": "e", "channel": "elevation", "sources": ["e.tif"], "quality": "best", "options": {"bounds": true, "fill": "none", "quantum": 0.25}}]})");
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  EXPECT_EQ(scene->layers[0].options, (channels::Options{{"mixture", "3"}, {"classes", "[]"}}));
  EXPECT_EQ(scene->layers[1].options, (channels::Options{{"bounds", "yes"}, {"fill", "none"}, {"quantum", "0.25"}}));
  EXPECT_EQ(scene->layers[1].quality, encode::Quality::kBest);
  const auto missing = read(R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [
    {"name": "m", "channel": "material", "sources": ["m.tif"], "options": {"classes": "nowhere.json"}}]})");
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, ErrorCode::kIo);
  EXPECT_NE(missing.error().message.find("nowhere.json"), std::string::npos) << missing.error().message;
}

TEST_F(SceneFile, AFolderOrAListIsAllItsFiles) {
  std::filesystem::create_directory(folder_ / "tiles");
  for (const char* name : {"tiles/b.tif", "tiles/a.tif"}) std::ofstream(folder_ / name) << "x";
  std::ofstream(folder_ / "list.txt") << "z.tif\ny.tif\n";
  const auto scene = read(R"({"format": "vt-scene", "version": 1, "name": "n",
    "layers": [{"name": "c", "channel": "color", "sources": [{"file": "tiles/", "nodata": 3}, "@list.txt"]}]})");
  ASSERT_TRUE(scene.has_value()) << scene.error().message;
  const std::vector<SourceRequest>& sources = scene->layers[0].sources;
  ASSERT_EQ(sources.size(), 4U);
  EXPECT_EQ(sources[0].path, folder_ / "tiles/a.tif");
  EXPECT_EQ(sources[1].path, folder_ / "tiles/b.tif");
  EXPECT_EQ(sources[1].nodata, std::vector{3.0});
  EXPECT_EQ(sources[2].path, folder_ / "z.tif");
  EXPECT_TRUE(sources[3].nodata.empty());
  expect_refused(R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [{"name": "c", "channel": "color", "sources": ["."]}]})",
                 "/layers/0/sources/0");
}

TEST_F(SceneFile, NamesTheJsonPathOfWhatIsWrong) {
  const std::string head = R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [)";
  expect_refused(head + R"({"name": "c", "channel": "colour", "sources": ["a.tif"]}]})", "/layers/0/channel");
  expect_refused(head + R"({"name": "c", "channel": "color", "sources": ["a.tif"], "tile": 100}]})", "/layers/0");
  expect_refused(
      head +
          R"({"name": "c", "channel": "color", "sources": ["a.tif"]}, {"name": "d", "channel": "color", "sources": [{"file": "b.tif", "nodata": "x"}]}]})",
      "/layers/1/sources/0");
  expect_refused(head + R"({"name": "c", "channel": "color", "sources": ["a.tif"], "colour": 1}]})", "/layers/0");
  expect_refused(R"({"format": "vt-scene", "version": 1, "name": "n"})", "at /");
  expect_refused("{\"format\": \"vt-scene\",", "line 1, column 23");
  expect_refused(
      head + R"({"name": "c", "channel": "color", "sources": ["a.tif"]}, {"name": "c", "channel": "color", "sources": ["a.tif"]}]})",
      "twice");
}

TEST_F(SceneFile, AnUnknownCoordinateSystemNamesItsPlace) {
  const auto scene = read(R"({"format": "vt-scene", "version": 1, "name": "n",
    "layers": [{"name": "c", "channel": "color", "sources": ["a.tif", {"file": "b.tif", "crs": "EPSG:9999"}]}]})");
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kUnsupported);
  for (const char* part : {"SCENE.json", "/layers/0/sources/1/crs", "EPSG:9999"})
    EXPECT_NE(scene.error().message.find(part), std::string::npos) << scene.error().message;
}

TEST_F(SceneFile, MissingFileIsAnInputError) {
  const auto scene = read_scene(folder_ / "none.json");
  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace vt::pipeline
