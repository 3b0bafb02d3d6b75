// vtbuild as people and scripts meet it: messages, exit codes, nothing left behind after a failure, and the
// whole way from a scene to a picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/picture_file.h"
#include "tests/cli/program_run.h"
#include "tests/support/temp_folder.h"

namespace vt::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class VtbuildTest : public testing::Test {
 protected:
  Outcome run(const std::vector<std::string>& arguments) { return run_program(VT_VTBUILD, arguments, folder_.path()); }
  Outcome inspect(const std::vector<std::string>& arguments) { return run_program(VT_VTINSPECT, arguments, folder_.path()); }
  void make_scene() { ASSERT_EQ(run({"sample", "-o", "scene", "--size", "512", "--progress", "none"}).exit_code, 0); }
  void expect_failure(const std::vector<std::string>& arguments, int exit_code, const std::vector<std::string>& phrases) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_THAT(outcome.err, StartsWith("vtbuild: "));
    for (const std::string& phrase : phrases) EXPECT_THAT(outcome.err, HasSubstr(phrase));
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name, std::ios::binary) << text; }
  bool exists(const std::string& name) { return std::filesystem::exists(folder_ / name); }

  TempFolder folder_;
};

TEST_F(VtbuildTest, HelpHasExamplesAndExitCodesEverywhere) {
  for (std::vector<std::string> arguments :
       std::vector<std::vector<std::string>>{{}, {"layer"}, {"dataset"}, {"sample"}, {"pack"}, {"remove"}}) {
    arguments.emplace_back("--help");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("Examples:\n  vtbuild "), HasSubstr("Exit codes:")));
  }
}

TEST_F(VtbuildTest, GoesTheWholeWay) {
  make_scene();
  const Outcome dry = run({"dataset", "scene/SCENE.json", "-o", "scene.vts", "--dry-run"});
  EXPECT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_THAT(dry.out, AllOf(HasSubstr("layer color"), HasSubstr("layer elevation"), HasSubstr("level  0"), HasSubstr("memory")));
  EXPECT_FALSE(exists("scene.vts")) << "--dry-run builds nothing";

  const Outcome built = run({"dataset", "scene/SCENE.json", "-o", "scene.vts", "--progress", "plain"});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_THAT(built.err, HasSubstr("building color"));
  EXPECT_EQ(inspect({"validate", "scene.vts"}).exit_code, 0);
  // The finest level of a lossless layer is the source, pixel for pixel and in its place.
  EXPECT_EQ(inspect({"compare", "scene.vts", "scene/imagery.tif", "--layer", "color"}).exit_code, 0);
  EXPECT_EQ(inspect({"compare", "scene.vts", "scene/elevation.tif", "--layer", "elevation"}).exit_code, 0);

  const Outcome again = run({"dataset", "scene/SCENE.json", "-o", "scene.vts", "--progress", "none"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.out, HasSubstr("already complete"));
}

TEST_F(VtbuildTest, WhatIsExtractedBuildsTheSameStore) {
  make_scene();
  ASSERT_EQ(run({"layer", "scene/imagery.tif", "-o", "a.vts", "--channel", "color"}).exit_code, 0);
  ASSERT_EQ(inspect({"extract", "a.vts", "-o", "back.tif"}).exit_code, 0);
  ASSERT_EQ(run({"layer", "back.tif", "-o", "b.vts", "--channel", "color"}).exit_code, 0);
  const Outcome compared = inspect({"compare", "a.vts", "b.vts"});
  EXPECT_EQ(compared.exit_code, 0) << compared.out << compared.err;
}

TEST_F(VtbuildTest, WrongUsageIsExitCodeOne) {
  make_scene();
  const std::string image = "scene/imagery.tif";
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {},
           {"nonsense"},
           {"layer"},
           {"layer", image, "-o", "x.vts"},
           {"layer", image, "-o", "x.vts", "--channel", "colour"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--kernel", "lanczos"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--format", "bc9"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--compression", "gzip"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--tile", "100"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--memory", "lots"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--memory", "1M"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--bands", "1,2,9"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--extent", "3,2,1,0"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--threads", "0"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--progress", "loud"},
           {"layer", image, "-o", "x.vts", "--channel", "color", "--gsd", "-1"},
           {"dataset"},
           {"sample"},
       }) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << testing::PrintToString(arguments) << outcome.err;
    EXPECT_THAT(outcome.err, Not(testing::IsEmpty()));
  }
  EXPECT_FALSE(exists("x.vts")) << "wrong usage leaves nothing behind";
}

TEST_F(VtbuildTest, BadInputSaysWhatAndWhere) {
  make_scene();
  write("text.tif", "this is not a picture");
  write("empty.tif", "");
  write("bad.json", R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [{"name": "c", "channel": "color", "sources": []}]})");
  write("broken.json", "{");
  write("not-a-store.vts", "hello");
  std::filesystem::copy_file(folder_ / "scene/imagery.tif", folder_ / "cut.tif");
  std::filesystem::resize_file(folder_ / "cut.tif", std::filesystem::file_size(folder_ / "cut.tif") / 2);
  expect_failure({"layer", "none.tif", "-o", "x.vts", "--channel", "color"}, 2, {"none.tif"});
  expect_failure({"layer", "text.tif", "-o", "x.vts", "--channel", "color"}, 3, {"text.tif"});
  expect_failure({"layer", "empty.tif", "-o", "x.vts", "--channel", "color"}, 3, {"empty.tif"});
  expect_failure({"layer", "cut.tif", "-o", "cut.vts", "--channel", "color", "--progress", "none"}, 3, {"cut.tif"});
  expect_failure({"dataset", "none.json", "-o", "x.vts"}, 2, {"none.json"});
  expect_failure({"dataset", "bad.json", "-o", "x.vts"}, 3, {"bad.json", "/layers/0/sources"});
  expect_failure({"dataset", "broken.json", "-o", "x.vts"}, 3, {"broken.json", "line 1, column 2"});
  expect_failure({"layer", "scene/imagery.tif", "-o", "not-a-store.vts", "--channel", "color"}, 3, {"not-a-store.vts"});
  expect_failure({"layer", "scene/imagery.tif", "-o", "no/such/folder/x.vts", "--channel", "color"}, 2, {"no/such/folder"});
  EXPECT_FALSE(exists("x.vts"));
}

// Formats that OpenImageIO would have tried, and crashed on; and all of a folder at once.
TEST_F(VtbuildTest, WhatIsNotReadIsNamedFileByFile) {
  write("picture.sgi", "\x01\xda\x01\x01" + std::string(509, '\x03'));
  write("ortho.tif", std::string("\0\0\1\0\1\0", 6) + std::string(100, '\0'));
  for (const char* name : {"picture.sgi", "ortho.tif"})
    expect_failure({"layer", name, "-o", "x.vts", "--channel", "color", "--crs", "pixel"}, 3, {name, "is in a format that is not read"});
  std::filesystem::create_directory(folder_ / "tiles");
  write("tiles/N36W112.hgt", std::string(2 * 1201 * 1201, '\0'));
  write("tiles/n36.dt1", "UHL1" + std::string(3000, ' '));
  write("tiles/grid.asc", "ncols 2\nnrows 2\n1 2 3 4\n");
  write("tiles/bad.tif", "II*");
  write("tiles/notes.asc", "-----BEGIN PGP SIGNATURE-----");
  expect_failure({"layer", "tiles", "-o", "x.vts", "--channel", "elevation"}, 3,
                 {"4 of 4 sources cannot be used", "HGT", "DTED", "ASCII grid", "bad.tif", "gdal_translate n36.dt1 new.tif"});
  EXPECT_FALSE(exists("x.vts"));
}

// Whoever opened one of them would wait for ever.
TEST_F(VtbuildTest, PipesAndDevicesAreRefusedAtOnce) {
  make_scene();
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  const std::string pipe = (folder_ / "pipe").string();
  for (const std::string& name : {pipe, std::string("/dev/zero")}) {
    const std::string kind = name == pipe ? " a pipe" : " a device";
    expect_failure({"layer", name, "-o", "x.vts", "--channel", "color"}, 2, {name, kind});
    expect_failure({"layer", "@" + name, "-o", "x.vts", "--channel", "color"}, 2, {name, kind});
    expect_failure({"dataset", name, "-o", "x.vts"}, 2, {name, kind});
    expect_failure({"layer", "scene/materials.tif", "-o", "x.vts", "--channel", "material", "--classes", name}, 2, {name, kind});
    write("scene.json", R"({"format": "vt-scene", "version": 1, "name": "n", "layers": [{"name": "c", "channel": "color", "sources": [")" +
                            name + R"("]}]})");
    expect_failure({"dataset", "scene.json", "-o", "x.vts"}, 2, {name, kind});
  }
  EXPECT_FALSE(exists("x.vts"));
}

TEST_F(VtbuildTest, TheCrsOfAFileIsOverruledBySourceCrsAlone) {
  make_scene();
  const Outcome kept =
      run({"layer", "scene/elevation.tif", "-o", "kept.vts", "--channel", "elevation", "--crs", "EPSG:4326", "--progress", "none"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_THAT(kept.err, HasSubstr("resampled")) << "placed by its own CRS in a store of another";
  const Outcome overruled = run(
      {"layer", "scene/elevation.tif", "-o", "other.vts", "--channel", "elevation", "--source-crs", "EPSG:32610", "--progress", "none"});
  EXPECT_EQ(overruled.exit_code, 0) << overruled.err;
  EXPECT_THAT(overruled.err, AllOf(HasSubstr("taken to be in EPSG:32610"), HasSubstr("as asked for")));
  expect_failure({"layer", "scene/elevation.tif", "-o", "x.vts", "--channel", "elevation", "--source-crs", "EPSG:4326"}, 3,
                 {"are no longitudes and latitudes in degrees", "look like metres"});
}

// An area and an extent across the antimeridian, and a layer that counts longitudes the other way round.
TEST_F(VtbuildTest, AScenesAreaMayLieAcrossTheAntimeridian) {
  write("a.pgm", "P5 20 20 255\n" + std::string(400, '\x40'));
  write("scene.json", R"({"format": "vt-scene", "version": 1, "name": "n", "crs": "EPSG:4326",
    "area": {"west": 160, "south": -20, "east": -160, "north": 20},
    "layers": [{"name": "one", "channel": "mask", "sources": [{"file": "a.pgm", "crs": "EPSG:4326", "extent": [170, -10, -170, 10]}]},
               {"name": "two", "channel": "mask", "sources": [{"file": "a.pgm", "crs": "EPSG:4326", "extent": [-190, -10, -170, 10]}]}]})");
  const Outcome built = run({"dataset", "scene.json", "-o", "a.vts", "--progress", "none"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const auto info = nlohmann::json::parse(inspect({"info", "a.vts", "--json"}).out);
  EXPECT_EQ(info.at("area"), (nlohmann::json{{"west", 160.0}, {"south", -20.0}, {"east", 200.0}, {"north", 20.0}})) << info.dump();
  for (const auto& layer : info.at("layers")) EXPECT_EQ(layer.at("grid").at("origin_x"), 170.0) << layer.dump();
}

TEST_F(VtbuildTest, AStoreThatExistsIsNotOverwritten) {
  make_scene();
  ASSERT_EQ(run({"layer", "scene/imagery.tif", "-o", "a.vts", "--channel", "color", "--progress", "none"}).exit_code, 0);
  expect_failure({"layer", "scene/imagery.tif", "-o", "a.vts", "--channel", "color", "--kernel", "box", "--progress", "none"}, 2,
                 {"color", "--name"});
  EXPECT_EQ(inspect({"validate", "a.vts"}).exit_code, 0);
  expect_failure({"layer", "scene/elevation.tif", "-o", "a.vts", "--channel", "elevation", "--crs", "EPSG:4326"}, 1,
                 {"EPSG:32633", "EPSG:4326"});
}

TEST_F(VtbuildTest, AFullDiskIsReportedAndTheStoreStaysWhole) {
  make_scene();
  // A file-size limit stands in for a full disk: the write fails in the same place with the same kind of
  // error.
  const Outcome outcome = run_program("/bin/sh",
                                      {"-c", std::string("ulimit -f 200; exec ") + VT_VTBUILD +
                                                 " layer scene/imagery.tif -o full.vts --channel color --compression none --progress none"},
                                      folder_.path());
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("run the same command again"));
  EXPECT_EQ(inspect({"validate", "full.vts"}).exit_code, 0);
  ASSERT_EQ(
      run({"layer", "scene/imagery.tif", "-o", "full.vts", "--channel", "color", "--compression", "none", "--progress", "none"}).exit_code,
      0);
  EXPECT_EQ(inspect({"compare", "full.vts", "scene/imagery.tif"}).exit_code, 0);
}

#ifdef VT_VTRENDER
TEST_F(VtbuildTest, AStoreIsDrawnOnBothPaths) {
  make_scene();
  ASSERT_EQ(run({"dataset", "scene/SCENE.json", "-o", "scene.vts", "--progress", "none"}).exit_code, 0);
  std::vector<Picture<std::uint8_t>> pictures;
  for (const char* path : {"gl12", "glsl"}) {
    const std::string picture = std::string(path) + ".png";
    const Outcome outcome = run_program(VT_VTRENDER, {"scene.vts", "--path", path, "--size", "320x180", "-o", picture}, folder_.path());
    if (outcome.exit_code == 3 && outcome.err.find("context") != std::string::npos)
      GTEST_SKIP() << "no OpenGL context to be had here: " << outcome.err;
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    pictures.push_back(read_png(folder_ / picture));
    ASSERT_EQ(pictures.back().width, 320);
    ASSERT_EQ(pictures.back().height, 180);
  }
  // The terrain stands in the middle of a plain sky. Both paths have the whole small layer in one texture, so
  // they draw the same texels with the same filter: a GLSL lookup differs from the fixed function's by 1 at
  // most, and 1 more for the window.
  const std::vector<std::uint8_t>& fixed = pictures[0].samples;
  const std::vector<std::uint8_t>& shaded = pictures[1].samples;
  std::set<std::array<std::uint8_t, 3>> colours;
  for (int y = 60; y < 140; ++y)
    for (int x = 110; x < 210; ++x) colours.insert({pictures[0].at(x, y, 0), pictures[0].at(x, y, 1), pictures[0].at(x, y, 2)});
  EXPECT_GT(colours.size(), 100U) << "imagery has hundreds of colours; a sky, a hole or an untextured surface has one";
  int largest = 0;
  for (std::size_t i = 0; i < fixed.size(); ++i) largest = std::max(largest, std::abs(int{fixed[i]} - int{shaded[i]}));
  EXPECT_LE(largest, 2);
}
#endif

#ifdef VT_VTRENDER
// The figures of a flight are of frames that draw: patches, from tiles that are loaded, of more than one
// level.
TEST_F(VtbuildTest, AFlightReportsTheTilesThatItsFramesDraw) {
  make_scene();
  ASSERT_EQ(run({"layer", "scene/imagery.tif", "-o", "scene.vts", "--channel", "color", "--progress", "none"}).exit_code, 0);
  for (const char* path : {"gl12", "glsl"}) {
    // Textures far smaller than the layer: its finest level is only there near the place that is flown over.
    const Outcome outcome = run_program(VT_VTRENDER,
                                        {"scene.vts", "--path", path, "--size", "160x90", "--tile-texels", "64", "--tiles-per-side", "2",
                                         "--frames", "12", "--fly", "--rate", "200", "--json"},
                                        folder_.path());
    if (outcome.exit_code == 3 && outcome.err.find("context") != std::string::npos)
      GTEST_SKIP() << "no OpenGL context to be had here: " << outcome.err;
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto frames = nlohmann::json::parse(outcome.out, nullptr, false)["frames"];
    EXPECT_EQ(frames["count"], 12);
    EXPECT_GE(frames["loaded"].get<int>(), 1) << "before the first frame everything is waited for";
    EXPECT_GE(frames["mean_patches"].get<double>(), 4.0);
    // One tile for each patch, which has to cover it; or, with shaders, fine ones over coarse ones.
    const bool combines = std::string_view(path) == "glsl";
    EXPECT_GE(frames["mean_tiles"].get<double>(), combines ? 2.0 : 1.0);
    EXPECT_GE(frames["mean_binds"].get<double>(), combines ? 2.0 : 1.0);
    EXPECT_GE(frames["levels"].size(), combines ? 2U : 1U) << outcome.out;
    EXPECT_GE(frames["own_median_ms"].get<double>(), frames["update_median_ms"].get<double>());
    EXPECT_GE(frames["own_median_ms"].get<double>(), frames["select_bind_median_ms"].get<double>());
    EXPECT_GT(frames["select_bind_median_ms"].get<double>(), 0.0);
    EXPECT_LE(frames["upload_most_bytes"].get<int>(), frames["upload_budget_bytes"].get<int>());
  }
}
#endif

TEST_F(VtbuildTest, UpdatesWhatChangedAndReportsItAsJson) {
  make_scene();
  const std::vector<std::string> command = {"layer",  "scene/imagery.tif", "-o",         "a.vts",  "--channel",
                                            "color",  "--block",           "1",          "--tile", "64",
                                            "--json", "--stats",           "--progress", "none"};
  const auto report_of = [&](const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto document = nlohmann::json::parse(outcome.out, nullptr, false);
    EXPECT_EQ(schema_complaints("vtbuild-report", document), "") << outcome.out;
    return document["layers"][0];
  };
  const auto built = report_of(command);
  EXPECT_GT(built["tile_changes"]["written"], 80);
  EXPECT_EQ(built["tile_changes"]["written"], built["tiles"]);
  EXPECT_GT(built["stage_seconds"]["read"], 0.0);

  std::vector<std::string> update = command;
  update.emplace_back("--update");
  const auto same = report_of(update);
  EXPECT_TRUE(same["was_complete"]);
  EXPECT_EQ(same["blocks"]["changed"], 0);
  EXPECT_EQ(same["blocks"]["checked"], 16);

  // One sample of the uncompressed file, near its end, in no piece that a quick look would hash.
  const auto size = std::filesystem::file_size(folder_ / "scene/imagery.tif");
  {
    std::fstream file(folder_ / "scene/imagery.tif", std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(static_cast<std::streamoff>(size - 70000));
    const int byte = file.get();
    file.seekp(static_cast<std::streamoff>(size - 70000));
    file.put(static_cast<char>(byte ^ 0x55));
  }
  const auto changed = report_of(update);
  EXPECT_FALSE(changed["was_complete"]);
  EXPECT_GE(changed["blocks"]["changed"], 1);
  EXPECT_LE(changed["blocks"]["changed"], 9);
  EXPECT_GE(changed["tile_changes"]["written"], 1);
  EXPECT_LT(changed["tile_changes"]["written"], 30);
}

// Two layers by two commands; the store knows both, and where their sources are.
TEST_F(VtbuildTest, UpdateKnowsTheCommandsThatBuiltTheStore) {
  make_scene();
  std::filesystem::create_directory(folder_ / "stores");
  ASSERT_EQ(run({"layer", "scene/imagery.tif", "-o", "stores/a.vts", "--channel", "color", "--tile", "64", "--progress", "none"}).exit_code,
            0);
  ASSERT_EQ(run({"layer", "scene/elevation.tif", "-o", "stores/a.vts", "--channel", "elevation", "--progress", "none"}).exit_code, 0);
  const Outcome same = run({"update", "stores/a.vts", "--progress", "none"});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_THAT(same.out, AllOf(HasSubstr("layer color"), HasSubstr("layer elevation"), HasSubstr("0 of 1 blocks have other sources"),
                              HasSubstr("nothing to do")));

  // Everything moves together, and the imagery changes.
  std::filesystem::create_directory(folder_ / "moved");
  std::filesystem::rename(folder_ / "scene", folder_ / "moved/scene");
  std::filesystem::rename(folder_ / "stores", folder_ / "moved/stores");
  {
    std::fstream file(folder_ / "moved/scene/imagery.tif", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(400000);
    file.put('\x77');
  }
  const Outcome changed = run({"update", "moved/stores/a.vts", "--progress", "none", "--json"});
  EXPECT_EQ(changed.exit_code, 0) << changed.err;
  const auto document = nlohmann::json::parse(changed.out, nullptr, false);
  EXPECT_EQ(schema_complaints("vtbuild-report", document), "") << changed.out;
  EXPECT_EQ(document["layers"][0]["blocks"]["changed"], 1);
  EXPECT_GE(document["layers"][0]["tile_changes"]["written"], 1);
  EXPECT_EQ(document["layers"][1]["blocks"]["changed"], 0);

  // The sources alone have moved.
  std::filesystem::rename(folder_ / "moved/scene", folder_ / "scene");
  expect_failure({"update", "moved/stores/a.vts"}, 2, {"imagery.tif"});
  EXPECT_EQ(run({"update", "moved/stores/a.vts", "--folder", ".", "--progress", "none"}).exit_code, 0);
}

}  // namespace
}  // namespace vt::test
