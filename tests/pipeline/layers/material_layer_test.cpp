// Layers of classes, built whole and held to counting: whatever the level, the finest level's texels under
// each of its texels, one by one.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "store/texel/texel_decoder.h"
#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// All samples of one layer, by level and place.
class Samples {
 public:
  Samples(const std::filesystem::path& store, const std::string& name) : tiles_(tiles_of(store, name)) {
    const auto reader = store::StoreReader::open(store);
    layer_ = *reader->find_layer(name);
    channels_ = format_info(layer_.format).channels;
    for (const auto& [tile, payload] : tiles_) {
      std::vector<float>& samples = decoded_[tile];
      samples.resize(static_cast<std::size_t>(layer_.tile_texels()) * layer_.tile_texels() * channels_);
      store::decode_texels(layer_.format, payload, layer_.tile_texels(), layer_.tile_texels(), samples);
    }
  }
  [[nodiscard]] const LayerInfo& layer() const { return layer_; }
  // `absent` where there is no tile.
  [[nodiscard]] int at(Level level, std::int64_t x, std::int64_t y, std::size_t channel, int absent) const {
    const int exponent = layer_.tile_exponent;
    const auto found = decoded_.find({level, static_cast<std::uint32_t>(x >> exponent), static_cast<std::uint32_t>(y >> exponent)});
    if (found == decoded_.end()) return absent;
    const std::int64_t edge = std::int64_t{1} << exponent;
    return static_cast<int>(found->second[static_cast<std::size_t>((y & (edge - 1)) * edge + (x & (edge - 1))) * channels_ + channel]);
  }

 private:
  Tiles tiles_;
  std::map<TileId, std::vector<float>> decoded_;
  LayerInfo layer_;
  std::size_t channels_ = 1;
};

using Histogram = std::map<int, std::int64_t>;

Histogram histogram_under(const Samples& layer, int no_data, int steps, std::int64_t x, std::int64_t y) {
  Histogram histogram;
  const TexelRect data = layer.layer().data;
  for (std::int64_t v = y << steps; v < std::min((y + 1) << steps, data.bottom()); ++v)
    for (std::int64_t u = x << steps; u < std::min((x + 1) << steps, data.right()); ++u)
      if (const int id = layer.at(layer.layer().finest, u, v, 0, no_data); id != no_data) ++histogram[id];
  return histogram;
}

// The lowest of the most frequent.
int majority_of(const Histogram& histogram, int no_data) {
  int best = no_data;
  std::int64_t most = 0;
  for (const auto& [id, count] : histogram)
    if (count > most) best = id, most = count;
  return best;
}

// Checks every texel of every level but the finest.
void expect_majorities(const std::filesystem::path& store, const std::string& name, int no_data) {
  const Samples samples(store, name);
  const LayerInfo& layer = samples.layer();
  for (int steps = 1; steps <= layer.finest.value; ++steps) {
    const Level level{static_cast<std::uint8_t>(layer.finest.value - steps)};
    const TexelRect rect = layer.data_rect(level);
    for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
      for (std::int64_t x = rect.x; x < rect.right(); ++x)
        ASSERT_EQ(samples.at(level, x, y, 0, no_data), majority_of(histogram_under(samples, no_data, steps, x, y), no_data))
            << name << " level " << int{level.value} << " texel " << x << ", " << y;
  }
}

LayerRequest classes_of(const std::filesystem::path& input, const channels::Options& options = {}) {
  LayerRequest request = request_for({input}, ChannelType::kMaterial);
  request.options = options;
  return request;
}

nlohmann::json metadata_of(const std::filesystem::path& store) {
  const auto reader = store::StoreReader::open(store);
  return nlohmann::json::parse(reader->find_layer("material")->metadata_json);
}

double forty_thirty_thirty(std::int64_t x, std::int64_t y, int) {
  const std::uint32_t noise = hash_noise(x, y, 0) % 10;
  return noise < 4 ? 3 : noise < 7 ? 1 : 200;
}

TEST(MaterialLayer, RandomClassesKeepTheirAreasOnEveryLevel) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 1024, .height = 1024, .bands = 1}, forty_thirty_thirty);
  build(folder / "a.vts", classes_of(folder / "classes.tif", {{"mixture", "4"}}));
  expect_majorities(folder / "a.vts", "material", 255);

  const Samples base(folder / "a.vts", "material");
  const Samples classes(folder / "a.vts", "material/classes");
  const Samples weights(folder / "a.vts", "material/weights");
  ASSERT_EQ(base.layer().finest.value, 5);
  const Histogram truth = histogram_under(base, 255, 10, 0, 0);
  for (int steps = 0; steps <= 5; ++steps) {
    const Level level{static_cast<std::uint8_t>(5 - steps)};
    const std::int64_t size = 1024 >> steps;
    std::map<int, double> area;
    for (std::int64_t y = 0; y < size; ++y)
      for (std::int64_t x = 0; x < size; ++x) {
        const Histogram here = histogram_under(base, 255, steps, x, y);
        int sum = 0;
        for (std::size_t rank = 0; rank < 4; ++rank) {
          const int id = classes.at(level, x, y, rank, 255);
          const int weight = weights.at(level, x, y, rank, 0);
          sum += weight;
          if (id == 255) {
            ASSERT_EQ(weight, 0);
            continue;
          }
          area[id] += weight / 255.0 * std::ldexp(1.0, 2 * steps);
          // Every share is off by less than one step.
          ASSERT_LT(std::abs(weight - std::ldexp(255.0 * static_cast<double>(here.at(id)), -2 * steps)), 1.0);
        }
        ASSERT_EQ(sum, 255) << "three classes leave no rest";
        ASSERT_EQ(classes.at(level, x, y, 0, 255), base.at(level, x, y, 0, 255));
      }
    double total = 0.0;
    for (const auto& [id, count] : truth) {
      // No texel is off by a whole step of 1/255, so neither is the sum.
      EXPECT_NEAR(area[id] / (1024.0 * 1024.0), static_cast<double>(count) / (1024.0 * 1024.0), 1.0 / 255.0) << "level " << 5 - steps;
      total += area[id];
    }
    EXPECT_NEAR(total, 1024.0 * 1024.0, 1e-3);
  }

  // What the majority alone loses grows with the level, what the mixture loses stays below a step.
  const nlohmann::json quality = metadata_of(folder / "a.vts").at("quality");
  ASSERT_EQ(quality[0].at("name"), "class area");
  EXPECT_EQ(quality[0].at("levels").front().at("mean"), 0.0);
  EXPECT_NEAR(quality[0].at("levels").back().at("mean").get<double>(), 59.0, 2.0) << "40 % of 1024 texels is the usual majority";
  ASSERT_EQ(quality[1].at("name"), "class area of the mixture");
  for (const auto& row : quality[1].at("levels")) {
    // Half of three shares, each off by less than a step.
    EXPECT_LT(row.at("max").get<double>(), 150.0 / 255.0);
    EXPECT_NEAR(row.at("kept").get<double>(), 1.0, 1e-9);
  }
}

TEST(MaterialLayer, MajoritiesAreOfTheFinestLevelAcrossTiersTilesAndHoles) {
  const auto patches = [](std::int64_t x, std::int64_t y, int) -> double {
    if ((x / 19 + y / 23) % 4 == 0) return 0;  // no data
    if ((x / 31) % 2 == 0) return 1 + hash_noise(x, y, 1) % 7;
    return 1 + (x / 11 * y / 13) % 250;
  };
  for (const auto& [width, height] : {std::pair<int, int>{301, 203}, {257, 1}, {1, 255}, {127, 129}, {1, 1}}) {
    const test::TempFolder folder;
    write_raster(folder / "classes.tif", {.width = width, .height = height, .bands = 1, .nodata = 0.0}, patches);
    build(folder / "a.vts", classes_of(folder / "classes.tif"), {.block_levels = 1});
    expect_majorities(folder / "a.vts", "material", 0);
    EXPECT_EQ(metadata_of(folder / "a.vts").at("no_data_class"), 0);
  }
}

TEST(MaterialLayer, EqualAreasGoToTheLowestClass) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 128, .height = 128, .bands = 1},
               [](std::int64_t x, std::int64_t y, int) { return (x + y) % 2 == 0 ? 250.0 : 13.0; });
  build(folder / "a.vts", classes_of(folder / "classes.tif"));
  const Samples samples(folder / "a.vts", "material");
  for (int level = 0; level < samples.layer().finest.value; ++level)
    EXPECT_EQ(samples.at(Level{static_cast<std::uint8_t>(level)}, 3, 5, 0, -1), 13);
}

// Class 9 holds three of four texels in every other square of four and class 2 two of four in the others.
// Each leads as many squares, so from the second level on the majority of majorities would be the lower
// class, 2; but 9 has 3/8 of the area and 2 has 2/8.
TEST(MaterialLayer, NoMajorityIsTakenOfMajorities) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 256, .height = 256, .bands = 1}, [](std::int64_t x, std::int64_t y, int) -> double {
    const std::int64_t corner = (y % 2) * 2 + x % 2;
    if ((x / 2 + y / 2) % 2 == 0) return corner == 3 ? 8.0 : 9.0;
    return corner < 2 ? 2.0 : static_cast<double>(2 + corner);
  });
  build(folder / "a.vts", classes_of(folder / "classes.tif"));
  expect_majorities(folder / "a.vts", "material", 255);
  const Samples samples(folder / "a.vts", "material");
  EXPECT_EQ(samples.at(Level{1}, 0, 0, 0, -1), 9);
  EXPECT_EQ(samples.at(Level{0}, 0, 0, 0, -1), 9);
}

TEST(MaterialLayer, AClassThatDoesNotFitStopsTheBuild) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 70, .height = 40, .bands = 1, .type = SampleType::kUint16},
               [](std::int64_t x, std::int64_t y, int) { return x == 61 && y == 37 ? 300.0 : 4.0; });
  LayerRequest request = classes_of(folder / "classes.tif");
  request.format = TexelFormat::kR8;
  const auto plan = plan_layer(request, std::nullopt, std::size_t{1} << 20);
  ASSERT_TRUE(plan.has_value());
  auto writer = open_or_create(folder / "a.vts", plan->crs, plan->extent());
  const auto report = build_layer(*writer, *plan, {});
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(report.error().message.find("texel 61, 37 of the finest level is class 300; this layer holds classes 0 to 255, as r16"),
            std::string::npos)
      << report.error().message;
}

TEST(MaterialLayer, SixteenBitsAreUsualForSixteenBitSamples) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 70, .height = 90, .bands = 1, .type = SampleType::kInt16, .nodata = -9999.0},
               [](std::int64_t x, std::int64_t y, int) { return x == y ? -9999.0 : 250.0 + hash_noise(x, y, 4) % 300; });
  build(folder / "a.vts", classes_of(folder / "classes.tif"));
  expect_majorities(folder / "a.vts", "material", 65535);
  EXPECT_EQ(Samples(folder / "a.vts", "material").layer().format, TexelFormat::kR16);
}

TEST(MaterialLayer, AMosaicOfDifferentNoDataKeepsOne) {
  const test::TempFolder folder;
  write_raster(folder / "west.tif", {.width = 40, .height = 40, .bands = 1, .nodata = 0.0},
               [](std::int64_t x, std::int64_t, int) { return x < 10 ? 0.0 : 5.0; });
  write_raster(folder / "east.tif",
               {.width = 40, .height = 40, .bands = 1, .nodata = 77.0, .transform = {500080.0, 2.0, 0.0, 5400000.0, 0.0, -2.0}},
               [](std::int64_t x, std::int64_t, int) { return x < 10 ? 77.0 : 6.0; });
  LayerRequest request = request_for({folder / "west.tif", folder / "east.tif"}, ChannelType::kMaterial);
  build(folder / "a.vts", request);
  const Samples samples(folder / "a.vts", "material");
  const Level finest = samples.layer().finest;
  EXPECT_EQ(samples.at(finest, 5, 5, 0, 0), 0);
  EXPECT_EQ(samples.at(finest, 15, 5, 0, 0), 5);
  EXPECT_EQ(samples.at(finest, 45, 5, 0, 0), 0);
  EXPECT_EQ(samples.at(finest, 55, 5, 0, 0), 6);
  expect_majorities(folder / "a.vts", "material", 0);
}

struct RealClasses {
  std::string file;
  int no_data;
};

TEST(MaterialLayer, RealLandCoverKeepsItsClasses) {
  const std::filesystem::path data = VT_TEST_DATA;
  if (!std::filesystem::exists(data / "truth.json"))
    GTEST_SKIP() << "no real rasters in " << data << "; set VT_TEST_DATA to compare with them";
  std::ifstream file(data / "truth.json");
  const nlohmann::json truth = nlohmann::json::parse(file);
  for (const RealClasses& c : {RealClasses{"landcover/berlin_landcover_map_l3.tif", 0}, RealClasses{"landcover/zion_nlcd2011.tif", 255},
                               RealClasses{"landcover/mt_hood_lf_fbfm40_220_utm.tif", 32767}}) {
    const auto facts = std::ranges::find_if(truth.at("files"), [&](const auto& one) { return one.at("path") == c.file; });
    ASSERT_NE(facts, truth.at("files").end());
    const nlohmann::json& band = facts->at("band_info").at(0);
    const test::TempFolder folder;
    build(folder / "a.vts", classes_of(data / c.file), {.block_levels = 2});
    const auto validation = store::validate(folder / "a.vts");
    ASSERT_TRUE(validation.has_value() && validation->ok());
    const Samples samples(folder / "a.vts", "material");
    const LayerInfo& layer = samples.layer();
    for (const nlohmann::json& sample : band.at("samples"))
      EXPECT_EQ(samples.at(layer.finest, sample[0], sample[1], 0, c.no_data), sample[2].get<int>()) << c.file;
    const Histogram all = histogram_under(samples, c.no_data, layer.finest.value + layer.tile_exponent, 0, 0);
    std::int64_t valid = 0;
    double sum = 0.0;
    for (const auto& [id, count] : all) valid += count, sum += static_cast<double>(id) * static_cast<double>(count);
    EXPECT_EQ(valid, band.at("valid_count").get<std::int64_t>()) << c.file;
    EXPECT_NEAR(sum / static_cast<double>(valid), band.at("valid_mean").get<double>(), 1e-9) << c.file;
    expect_majorities(folder / "a.vts", "material", c.no_data);
  }
}

}  // namespace
}  // namespace vt::pipeline
