#include "builder/sample/sample_scene.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

#include "builder/sample/bands.h"
#include "builder/source/raster_source.h"
#include "tests/sample/schema_check.h"
#include "tests/support/temp_folder.h"

namespace vt::sample {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFiles{"imagery.tif", "elevation.tif", "materials.tif", "materials.json", "lights.json", "SCENE.json"};

class SampleScene : public testing::Test {
 protected:
  // Writes a scene into a folder of its own.
  fs::path write(const std::string& name, std::int64_t size, std::uint64_t seed = 1) {
    const fs::path folder = dir_ / name;
    const Result<void> written = write_sample_scene(folder, {.size = size, .seed = seed, .progress = {}});
    EXPECT_TRUE(written) << written.error().message;
    return folder;
  }
  static std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static nlohmann::json json_of(const fs::path& path) { return nlohmann::json::parse(bytes_of(path)); }

  const test::TempFolder temp_;
  const fs::path dir_ = temp_ / "scenes";  // not made yet
};

TEST_F(SampleScene, SameBytesTwiceAndAtAnyThreadCount) {
  fs::path one, two;
  tbb::task_arena(1).execute([&] { one = write("one", 520); });
  tbb::task_arena(2).execute([&] { two = write("two", 520); });
  const fs::path again = write("again", 520);
  const fs::path other = write("other", 520, 2);
  for (const std::string& file : kFiles) {
    EXPECT_FALSE(bytes_of(one / file).empty()) << file;
    EXPECT_TRUE(bytes_of(one / file) == bytes_of(two / file)) << file << " differs between 1 and 2 threads";
    EXPECT_TRUE(bytes_of(one / file) == bytes_of(again / file)) << file << " differs on the second run";
  }
  EXPECT_FALSE(bytes_of(one / "imagery.tif") == bytes_of(other / "imagery.tif"));
  EXPECT_EQ(std::distance(fs::directory_iterator(one), fs::directory_iterator()), static_cast<std::ptrdiff_t>(kFiles.size()));
}

TEST_F(SampleScene, FilesCoverTheSameGround) {
  const fs::path folder = write("scene", 64);
  const nlohmann::json scene = json_of(folder / "SCENE.json");
  const struct {
    const char* file;
    std::int64_t width;
    int bands;
    source::SampleType type;
  } rasters[] = {{"imagery.tif", 64, 3, source::SampleType::kUint8},
                 {"elevation.tif", 16, 1, source::SampleType::kFloat32},
                 {"materials.tif", 32, 1, source::SampleType::kUint8}};
  for (const auto& raster : rasters) {
    const auto opened = source::open_raster(folder / raster.file);
    ASSERT_TRUE(opened) << opened.error().message;
    const source::RasterInfo& info = (*opened)->info();
    EXPECT_EQ(info.width, raster.width);
    EXPECT_EQ(info.height, raster.width);
    EXPECT_EQ(info.bands, raster.bands);
    EXPECT_EQ(info.sample_type, raster.type);
    EXPECT_TRUE(info.tiled);
    EXPECT_EQ(info.compression, "none");
    ASSERT_TRUE(info.has_transform);
    ASSERT_TRUE(info.transform.is_north_up());
    ASSERT_TRUE(info.crs) << info.crs_problem;
    EXPECT_EQ(info.crs->definition().epsg, 32633);
    const Point2 north_west = info.transform.crs_from_raster({0.0, 0.0});
    const Point2 south_east = info.transform.crs_from_raster({static_cast<double>(info.width), static_cast<double>(info.height)});
    EXPECT_EQ(north_west.x, scene["area"]["west"].get<double>());
    EXPECT_EQ(north_west.y, scene["area"]["north"].get<double>());
    EXPECT_EQ(south_east.x, scene["area"]["east"].get<double>());
    EXPECT_EQ(south_east.y, scene["area"]["south"].get<double>());
    EXPECT_EQ(info.meaning.at(0).nodata.has_value(), raster.type == source::SampleType::kFloat32);
  }
  EXPECT_EQ(*(*source::open_raster(folder / "elevation.tif"))->info().meaning.at(0).nodata, -9999.0);
}

TEST_F(SampleScene, FilesHoldTheBands) {
  constexpr std::int64_t kSize = 328;
  const fs::path folder = write("scene", kSize);
  const World world(1);
  Band band;
  paint_band(world, kSize, 1, band);  // the second, shorter band
  const auto read = [&](const char* file, std::int64_t step, std::vector<int> bands, std::size_t texel_bytes) {
    const auto opened = source::open_raster(folder / file);
    EXPECT_TRUE(opened);
    const std::int64_t width = kSize / step;
    const std::int64_t first = kSquare / step;
    std::vector<std::byte> out(static_cast<std::size_t>(width * (width - first)) * texel_bytes);
    const Result<void> done = (*opened)->read({.x = 0, .y = first, .width = width, .height = width - first}, bands, out,
                                              static_cast<std::size_t>(width) * texel_bytes);
    EXPECT_TRUE(done) << done.error().message;
    return out;
  };
  const auto same = [](const std::vector<std::byte>& file, const auto& samples) {
    const auto bytes = std::as_bytes(std::span(samples));
    return std::equal(file.begin(), file.end(), bytes.begin(), bytes.end());
  };
  EXPECT_TRUE(same(read("imagery.tif", 1, {0, 1, 2}, 3), band.rgb));
  EXPECT_TRUE(same(read("materials.tif", kMaterialStep, {0}, 1), band.material));
  EXPECT_TRUE(same(read("elevation.tif", kHeightStep, {0}, 4), band.height_m));
}

TEST_F(SampleScene, SceneFollowsTheSchemaAndItsFilesExist) {
  const fs::path folder = write("scene", 64);
  const nlohmann::json scene = json_of(folder / "SCENE.json");
  EXPECT_EQ(schema_complaint(scene), "");
  for (const auto& layer : scene["layers"]) {
    for (const auto& file : layer["sources"]) {
      const auto opened = source::open_raster(folder / file.get<std::string>());
      ASSERT_TRUE(opened) << opened.error().message;
      EXPECT_EQ((*opened)->info().transform.x_column, layer["gsd"].get<double>());
    }
  }
  for (const auto& reference : scene["references"]) EXPECT_TRUE(fs::exists(folder / reference["file"].get<std::string>()));

  const nlohmann::json materials = json_of(folder / "materials.json");
  EXPECT_EQ(materials["classes"].size(), 9U);
  EXPECT_EQ(materials["classes"][0]["name"], "water");
  EXPECT_EQ(materials["classes"][0]["id"], static_cast<int>(Material::kWater));
}

TEST_F(SampleScene, LightsLieInTheArea) {
  const fs::path folder = write("scene", 1024);
  const nlohmann::json scene = json_of(folder / "SCENE.json");
  const nlohmann::json lights = json_of(folder / "lights.json");
  EXPECT_EQ(lights["crs"], scene["crs"]);
  EXPECT_EQ(lights["lights"].size(), lights_of(World(1), 1024).size());
  EXPECT_GT(lights["lights"].size(), 20U);
  for (const auto& light : lights["lights"]) {
    EXPECT_GE(light["position"][0].get<double>(), scene["area"]["west"].get<double>());
    EXPECT_LE(light["position"][0].get<double>(), scene["area"]["east"].get<double>());
    EXPECT_GE(light["position"][1].get<double>(), scene["area"]["south"].get<double>());
    EXPECT_LE(light["position"][1].get<double>(), scene["area"]["north"].get<double>());
    EXPECT_EQ(light["color"].size(), 3U);
    EXPECT_GT(light["height_m"].get<double>(), 0.0);
    EXPECT_GT(light["power_w"].get<double>(), 0.0);
  }
}

TEST_F(SampleScene, RefusesSizesThatItCannotMake) {
  for (const std::int64_t size : {-8, 0, 8, 20, 1028, 65544}) {
    const Result<void> written = write_sample_scene(dir_, {.size = size, .seed = 1, .progress = {}});
    ASSERT_FALSE(written) << size;
    EXPECT_EQ(written.error().code, ErrorCode::kUsage);
  }
  EXPECT_FALSE(fs::exists(dir_)) << "a refusal leaves nothing behind";
}

TEST_F(SampleScene, CancelLeavesNoHalfFiles) {
  const auto cancel = [](double fraction) { return fraction < 0.4; };
  const Result<void> written = write_sample_scene(dir_, {.size = 776, .seed = 1, .progress = cancel});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(fs::is_empty(dir_));
}

TEST_F(SampleScene, ProgressRisesToOne) {
  std::vector<double> fractions;
  const auto note = [&](double fraction) {
    fractions.push_back(fraction);
    return true;
  };
  ASSERT_TRUE(write_sample_scene(dir_, {.size = 520, .seed = 1, .progress = note}));
  ASSERT_GE(fractions.size(), 3U);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.front(), 0.0);
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST_F(SampleScene, FolderThatCannotBeMadeIsAnError) {
  fs::create_directories(dir_);
  std::ofstream(dir_ / "file") << "x";
  const Result<void> written = write_sample_scene(dir_ / "file" / "folder", {.size = 64, .seed = 1, .progress = {}});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_NE(written.error().message.find("folder"), std::string::npos);
}

}  // namespace
}  // namespace vt::sample
