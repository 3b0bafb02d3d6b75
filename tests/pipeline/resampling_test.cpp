// Layers that are coarser than their sources: what each channel promises of its levels holds from the finest
// one on.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/pipeline/layer_values.h"
#include "tests/pipeline/layers/layer_kinds.h"
#include "tests/pipeline/level_values.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// Samples of 2 m, as RasterSpec has them.
constexpr std::int64_t kEdge = 256;

nlohmann::json quality_of(const std::filesystem::path& store_path, const std::string& layer, const std::string& measure) {
  const auto reader = store::StoreReader::open(store_path);
  EXPECT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo* info = reader->find_layer(layer);
  const nlohmann::json metadata = nlohmann::json::parse(info->metadata_json);
  for (const auto& entry : metadata.at("quality"))
    if (entry["name"] == measure)
      for (const auto& row : entry["levels"])
        if (row["level"] == info->finest.value) return row;
  ADD_FAILURE() << "nothing is reported of " << measure;
  return {};
}

LevelValues finest_of(const std::filesystem::path& store_path, const std::string& layer) {
  const auto reader = store::StoreReader::open(store_path);
  EXPECT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo* info = reader->find_layer(layer);
  return {*reader, *info, info->finest};
}

double mean_of(const LevelValues& level, std::size_t component = 0) {
  double sum = 0.0;
  for (std::int64_t y = 0; y < level.height(); ++y)
    for (std::int64_t x = 0; x < level.width(); ++x) sum += level.at(x, y, component);
  return sum / static_cast<double>(level.width() * level.height());
}

class Coarser : public testing::Test {
 protected:
  void write(const RasterSpec& spec, const std::function<double(std::int64_t, std::int64_t, int)>& value) {
    write_raster(folder_ / "in.tif", spec, value);
  }
  LayerRequest request(ChannelType channel, double gsd_m) {
    LayerRequest made = request_for({folder_ / "in.tif"}, channel);
    made.gsd_m = gsd_m;
    return made;
  }
  [[nodiscard]] std::filesystem::path store() const { return folder_ / "out.vts"; }

  test::TempFolder folder_;
};

TEST_F(Coarser, LampsKeepTheirLight) {
  write({.width = kEdge, .height = kEdge, .type = SampleType::kFloat32},
        [](std::int64_t x, std::int64_t y, int) { return x % 8 == 0 && y % 8 == 0 ? 64.0 : 0.0; });
  for (const double gsd_m : {16.0, 5.0, 32.0, 6.4}) {
    std::filesystem::remove(store());
    LayerRequest lights = request(ChannelType::kIllumination, gsd_m);
    lights.format = TexelFormat::kRgba32Float;
    build(store(), lights);
    // Where the raster ends inside a texel, that texel is all of what is there: only whole texels keep the
    // sum exactly.
    if (std::fmod(2.0 * kEdge, gsd_m) == 0.0) {
      EXPECT_NEAR(mean_of(finest_of(store(), "illumination")), 1.0, 1e-6) << gsd_m;
    } else {
      EXPECT_NEAR(mean_of(finest_of(store(), "illumination")), 1.0, 0.02) << gsd_m;
    }
    EXPECT_NEAR(quality_of(store(), "illumination", "light")["kept"].get<double>(), 1.0, 1e-6);
  }
}

TEST_F(Coarser, RadianceIsThatOfTheArea) {
  write({.width = kEdge, .height = kEdge, .bands = 1, .type = SampleType::kFloat32},
        [](std::int64_t x, std::int64_t, int) { return x % 8 == 3 ? 8.0 : 0.0; });
  LayerRequest radiance = request(ChannelType::kSensor, 16.0);
  build(store(), radiance);
  const LevelValues level = finest_of(store(), "sensor");
  for (std::int64_t y = 0; y < level.height(); ++y)
    for (std::int64_t x = 0; x < level.width(); ++x) ASSERT_NEAR(level.at(x, y), 1.0, 1e-7);
}

// A temperature of an area is that of its mean radiance: above the mean temperature.
TEST_F(Coarser, TemperaturesAreThoseOfTheMeanRadiance) {
  write({.width = kEdge, .height = kEdge, .bands = 1, .type = SampleType::kFloat32},
        [](std::int64_t x, std::int64_t, int) { return x % 2 == 0 ? 500.0 : 250.0; });
  LayerRequest kelvins = request(ChannelType::kSensor, 8.0);
  kelvins.options = {{"quantity", "temperature"}, {"band", "3,5"}, {"store", "temperature"}};
  build(store(), kelvins);
  const LevelValues level = finest_of(store(), "sensor");
  EXPECT_GT(level.at(5, 5), 440.0);
  EXPECT_LT(level.at(5, 5), 500.0);
}

TEST_F(Coarser, NoClassIsLost) {
  // Class 9 on an eighth of the area, in rows of one sample; 1 and 2 by chance.
  write({.width = kEdge, .height = kEdge, .bands = 1}, [](std::int64_t x, std::int64_t y, int) {
    return y % 8 == 0 ? 9.0 : hash_noise(x, y, 0) % 10 < 3 ? 2.0 : 1.0;
  });
  LayerRequest classes = request(ChannelType::kMaterial, 16.0);
  classes.options = {{"mixture", "4"}};
  build(store(), classes);
  Values ids(store(), "material/classes");
  Values shares(store(), "material/weights");
  double error = 0.0;
  for (std::int64_t y = 0; y < 32; ++y)
    for (std::int64_t x = 0; x < 32; ++x) {
      std::map<int, double> found;
      for (std::size_t rank = 0; rank < 4; ++rank)
        if (shares.at(0, x, y)[rank] > 0.0) found[static_cast<int>(ids.at(0, x, y)[rank])] = shares.at(0, x, y)[rank];
      std::map<int, double> wanted;
      for (std::int64_t v = 0; v < 8; ++v)
        for (std::int64_t u = 0; u < 8; ++u) wanted[v == 0 ? 9 : hash_noise(x * 8 + u, y * 8 + v, 0) % 10 < 3 ? 2 : 1] += 1.0 / 64;
      // Shares are stored in 255ths, rounded such that they sum to one.
      for (const auto& [id, share] : wanted) ASSERT_NEAR(found[id], share, 1.0 / 255) << x << "," << y << " class " << id;
      error += 100.0 * (1.0 - std::max(wanted[1], wanted[2]));
    }
  // In the layer itself the majority stands for all: the rest of the area is reported as taken for another
  // class.
  EXPECT_NEAR(quality_of(store(), "material", "class area")["mean"].get<double>(), error / 1024, 0.01);
  EXPECT_LT(quality_of(store(), "material", "class area of the mixture")["max"].get<double>(), 0.6);
}

// Coarser levels count the samples, not the texels that were made of them.
TEST_F(Coarser, ClassesOfAllLevelsAreCountedFromTheSamples) {
  write({.width = kEdge, .height = kEdge, .bands = 1, .nodata = 0.0}, [](std::int64_t x, std::int64_t y, int) {
    return (x / 40 + y / 40) % 3 == 0 ? 0.0 : hash_noise(x, y, 0) % 5 < 3 ? 4.0 : 6.0;
  });
  LayerRequest classes = request(ChannelType::kMaterial, 8.0);
  classes.options = {{"mixture", "2"}};
  for (const int block_levels : {1, 3}) {
    std::filesystem::remove(store());
    build(store(), classes, {.threads = 2, .block_levels = block_levels});
    Values ids(store(), "material/classes");
    Values shares(store(), "material/weights");
    for (int steps = 0; steps < 2; ++steps) {
      const std::int64_t edge = std::int64_t{4} << steps;
      for (std::int64_t y = 0; y < kEdge / edge; ++y)
        for (std::int64_t x = 0; x < kEdge / edge; ++x) {
          std::map<int, double> wanted;
          double all = 0.0;
          for (std::int64_t v = y * edge; v < (y + 1) * edge; ++v)
            for (std::int64_t u = x * edge; u < (x + 1) * edge; ++u) {
              if ((u / 40 + v / 40) % 3 == 0) continue;
              wanted[hash_noise(u, v, 0) % 5 < 3 ? 4 : 6] += 1.0;
              all += 1.0;
            }
          for (std::size_t rank = 0; rank < 2; ++rank) {
            const double share = shares.at(steps, x, y)[rank];
            if (all == 0.0) {
              ASSERT_EQ(share, 0.0);
              continue;
            }
            if (share > 0.0) {
              ASSERT_NEAR(share, wanted[static_cast<int>(ids.at(steps, x, y)[rank])] / all, 1.0 / 255);
            }
          }
        }
    }
  }
}

TEST_F(Coarser, BoundsHoldEveryPeak) {
  write({.width = kEdge, .height = kEdge, .bands = 1, .type = SampleType::kFloat32}, [](std::int64_t x, std::int64_t y, int) {
    return 100.0 + (x % 8 == 0 && y % 8 == 0 ? 900.0 : 0.0) - (x % 16 == 7 && y % 16 == 5 ? 300.0 : 0.0);
  });
  for (const double gsd_m : {8.0, 5.3}) {
    std::filesystem::remove(store());
    LayerRequest heights = request(ChannelType::kElevation, gsd_m);
    heights.options = {{"bounds", "yes"}};
    build(store(), heights);
    const auto reader = store::StoreReader::open(store());
    const LayerInfo* bounds = reader->find_layer("elevation/bounds");
    const double texel = gsd_m / 2.0;  // samples
    for (int steps = 1; steps <= bounds->finest.value; ++steps) {
      const LevelValues level(*reader, *bounds, Level{static_cast<std::uint8_t>(bounds->finest.value - steps)});
      const double edge = std::ldexp(texel, steps);
      for (std::int64_t y = 0; y < level.height(); ++y)
        for (std::int64_t x = 0; x < level.width(); ++x) {
          const auto first = [&](std::int64_t i) { return static_cast<std::int64_t>(std::floor(static_cast<double>(i) * edge + 1e-3)); };
          const auto end = [&](std::int64_t i) {
            return std::min(kEdge, static_cast<std::int64_t>(std::ceil(static_cast<double>(i + 1) * edge - 1e-3)));
          };
          for (std::int64_t v = first(y); v < end(y); ++v)
            for (std::int64_t u = first(x); u < end(x); ++u) {
              if (level.is_void(x, y)) continue;
              const double height = 100.0 + (u % 8 == 0 && v % 8 == 0 ? 900.0 : 0.0) - (u % 16 == 7 && v % 16 == 5 ? 300.0 : 0.0);
              ASSERT_LE(level.at(x, y, 0), height) << steps << " " << x << "," << y;
              ASSERT_GE(level.at(x, y, 1), height) << steps << " " << x << "," << y;
            }
        }
    }
  }
}

// Heights are those of a surface: a slope stays where it is at any ratio, in any projection.
TEST_F(Coarser, SlopesStayInTheirPlace) {
  RasterSpec spec{.width = 300, .height = 240, .bands = 1, .type = SampleType::kFloat32};
  for (const double ratio : {1.1, 1.25, 1.5, 2.0, 2.3, 3.7}) {
    write(spec, [](std::int64_t x, std::int64_t y, int) { return (static_cast<double>(x) + 0.5) - 2.0 * (static_cast<double>(y) + 0.5); });
    std::filesystem::remove(store());
    build(store(), request(ChannelType::kElevation, 2.0 * ratio));
    const LevelValues level = finest_of(store(), "elevation");
    for (std::int64_t y = 0; y < level.height(); ++y)
      for (std::int64_t x = 0; x < level.width(); ++x) {
        const double column = (static_cast<double>(x) + 0.5) * ratio;
        const double row = (static_cast<double>(y) + 0.5) * ratio;
        if (column > 299.5 || row > 239.5) continue;
        ASSERT_NEAR(level.at(x, y), column - 2.0 * row, 1e-4) << ratio << ": " << x << "," << y;  // floats of up to 480
      }
  }
}

TEST(CoarserInsets, AreMeansInsideAMosaic) {
  const test::TempFolder folder;
  RasterSpec base{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  base.transform = {500000.0, 10.0, 0.0, 5000000.0, 0.0, -10.0};
  write_raster(folder / "base.tif", base, [](auto, auto, int) { return 7.0; });
  RasterSpec fine = base;
  fine.width = fine.height = 320;
  fine.transform = {500100.0, 1.0, 0.0, 4999900.0, 0.0, -1.0};
  const auto noise = [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(hash_noise(x, y, 0) % 1000); };
  write_raster(folder / "fine.tif", fine, noise);
  build(folder / "out.vts", request_for({folder / "base.tif", folder / "fine.tif"}, ChannelType::kSensor));
  const LevelValues level = finest_of(folder / "out.vts", "sensor");
  ASSERT_EQ(level.width(), 64);
  for (std::int64_t y = 0; y < 64; ++y)
    for (std::int64_t x = 0; x < 64; ++x) {
      double wanted = 7.0;
      if (x >= 10 && x < 42 && y >= 10 && y < 42) {
        wanted = 0.0;
        for (std::int64_t v = 0; v < 10; ++v)
          for (std::int64_t u = 0; u < 10; ++u) wanted += noise((x - 10) * 10 + u, (y - 10) * 10 + v, 0) / 100.0;
      }
      ASSERT_NEAR(level.at(x, y), wanted, 1e-4) << x << "," << y;  // floats of up to 1000
    }
}

// Insets on both sides of the line where longitudes jump: columns of one level lie past it, and blocks see
// across it.
TEST(CoarserInsets, ClassesAreCountedAcrossTheSeamOfAGlobe) {
  const test::TempFolder folder;
  constexpr std::int64_t kWidth = 260;  // twice halved whole; the third time a texel holds ground of both ends
  constexpr std::int64_t kHeight = 24;
  const auto coarse_class = [](std::int64_t x, std::int64_t y) { return static_cast<int>(1 + hash_noise(x, y, 0) % 2); };
  const auto fine_class = [](std::int64_t x, std::int64_t y) { return static_cast<int>(3 + hash_noise(x, y, 1) % 2); };
  const RasterSpec base = around_the_globe(kWidth, kHeight, 1);
  write_raster(folder / "base.tif", base, [&](auto x, auto y, int) { return coarse_class(x, y); });
  // 4 x 4 samples a texel, 10 x 10 texels each, from row 2 on.
  RasterSpec inset = base;
  inset.width = inset.height = 40;
  inset.transform.x_column /= 4;
  inset.transform.y_row /= 4;
  inset.transform.y0 += 2 * base.transform.y_row;
  write_raster(folder / "west.tif", inset, [&](auto x, auto y, int) { return fine_class(x, y); });
  inset.transform.x0 = 180.0 - 10 * base.transform.x_column;
  write_raster(folder / "east.tif", inset, [&](auto x, auto y, int) { return fine_class(x + 4 * (kWidth - 10), y); });
  LayerRequest classes = request_for({folder / "base.tif", folder / "west.tif", folder / "east.tif"}, ChannelType::kMaterial);
  classes.options = {{"mixture", "4"}};

  // In sixteenths of a texel of the finest level.
  const auto add_texel = [&](std::int64_t x, std::int64_t y, std::map<int, int>& found) {
    const bool is_fine = y >= 2 && y < 12 && (x < 10 || x >= kWidth - 10);
    for (std::int64_t i = 0; i < 16; ++i) ++found[is_fine ? fine_class(4 * x + i % 4, 4 * (y - 2) + i / 4) : coarse_class(x, y)];
  };
  for (const int block_levels : {1, 3}) {
    std::filesystem::remove(folder / "out.vts");
    build(folder / "out.vts", classes, {.threads = 2, .block_levels = block_levels});
    Values ids(folder / "out.vts", "material/classes");
    Values shares(folder / "out.vts", "material/weights");
    for (int steps = 0; steps < 4; ++steps) {
      const std::int64_t edge = std::int64_t{1} << steps;
      for (std::int64_t y = 0; y < kHeight / edge; ++y)
        for (std::int64_t x = 0; x < (kWidth + edge - 1) / edge; ++x) {
          std::map<int, int> wanted;
          for (std::int64_t i = 0; i < edge * edge; ++i) add_texel((x * edge + i % edge) % kWidth, y * edge + i / edge, wanted);
          for (std::size_t rank = 0; rank < wanted.size(); ++rank) {
            const double share = shares.at(steps, x, y)[rank];
            ASSERT_GT(share, 0.0);
            // Shares are stored in 255ths, rounded such that they sum to one.
            const int id = static_cast<int>(ids.at(steps, x, y)[rank]);
            ASSERT_NEAR(share, wanted[id] / (16.0 * static_cast<double>(edge * edge)), 1.0 / 255)
                << steps << " steps, " << x << "," << y << " class " << id;
          }
        }
    }
  }
}

// White noise in Web Mercator, on a grid of degrees: towards the poles ever more rows lie under a texel, and
// their mean is ever calmer.
TEST(CoarserProjections, TheStretchOfLatitudesIsAveraged) {
  const test::TempFolder folder;
  RasterSpec spec{.width = 400, .height = 400, .bands = 1, .type = SampleType::kFloat32};
  spec.transform = {-2e7, 1e5, 0.0, 2e7, 0.0, -1e5};
  spec.epsg = 3857;
  write_raster(folder / "mercator.tif", spec, [](std::int64_t x, std::int64_t y, int) { return hash_noise(x, y, 0) % 1000 / 1000.0; });
  LayerRequest request = request_for({folder / "mercator.tif"}, ChannelType::kSensor);
  request.crs = geo::Crs::from_epsg(4326).value();
  build(folder / "out.vts", request);
  const auto reader = store::StoreReader::open(folder / "out.vts");
  const LayerInfo& info = *reader->find_layer("sensor");
  const LevelValues level(*reader, info, info.finest);
  const auto deviation_between = [&](double from, double to) {
    double sum = 0.0;
    double squares = 0.0;
    int count = 0;
    for (std::int64_t y = 0; y < level.height(); ++y) {
      const double latitude = info.grid.origin_y - (static_cast<double>(y) + 0.5) * info.grid.step_y;
      if (std::abs(latitude) < from || std::abs(latitude) > to) continue;
      for (std::int64_t x = 0; x < level.width(); ++x, ++count) {
        sum += level.at(x, y);
        squares += level.at(x, y) * level.at(x, y);
      }
    }
    return std::sqrt(squares / count - sum / count * (sum / count));
  };
  // Rows of 100 km on the map are 0.9 degrees times the cosine on the ground: 4.4 under a texel at 77
  // degrees. A column counts 1 sample or, between two, half of each, so the deviation of uniform noise,
  // 0.289, goes down to 0.138 to 0.098.
  EXPECT_LT(deviation_between(74.0, 80.0), 0.289 / std::sqrt(4.4) * 1.03);
  EXPECT_GT(deviation_between(74.0, 80.0), 0.289 / std::sqrt(4.4) * 0.65);
}

class UpdateOfCoarser : public Coarser {};

TEST_F(UpdateOfCoarser, AChangedSampleCostsTheBlocksOverIt) {
  const auto value = [](std::int64_t x, std::int64_t y, int band) { return static_cast<double>(hash_noise(x, y, band) % 256); };
  const RasterSpec spec{.width = 1500, .height = 900};
  write(spec, value);
  LayerRequest colors = request(ChannelType::kColor, 5.0);
  build(store(), colors, {.threads = 2, .block_levels = 1});
  EXPECT_TRUE(build(store(), colors, {.block_levels = 1, .update = true}).was_complete);
  write(spec,
        [&](std::int64_t x, std::int64_t y, int band) { return x == 800 && y == 400 ? 255.0 - value(x, y, band) : value(x, y, band); });
  const BuildReport report = build(store(), colors, {.threads = 2, .block_levels = 1, .update = true});
  EXPECT_GE(report.blocks_changed, 1);
  // The source's tiles of 64 samples are 26 texels, blocks are 64 and read an apron: 2 x 2 of the 10 x 6 at
  // most.
  EXPECT_LE(report.blocks_changed, 4);
  build(folder_ / "anew.vts", colors, {.threads = 1, .block_levels = 1});
  EXPECT_TRUE(tiles_of(store(), "color") == tiles_of(folder_ / "anew.vts", "color"));
  EXPECT_TRUE(tiles_of(store(), "color/carry") == tiles_of(folder_ / "anew.vts", "color/carry"));
}

// A layer of classes whose texels were all of one class begins to count parts of texels: all its counts are
// of the new unit then.
TEST_F(UpdateOfCoarser, CountsOfClassesAreOfOneUnit) {
  const RasterSpec spec{.width = 400, .height = 300, .bands = 1};
  write(spec, [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(1 + (x / 9 + y / 11) % 5); });
  RasterSpec fine{.width = 200, .height = 200, .bands = 1};
  fine.transform = {500100.0, 0.7, 0.0, 5399900.0, 0.0, -0.7};
  write_raster(folder_ / "fine.tif", fine,
               [](std::int64_t x, std::int64_t y, int) { return static_cast<double>(6 + hash_noise(x, y, 0) % 3); });
  LayerRequest classes = request_for({folder_ / "in.tif"}, ChannelType::kMaterial);
  classes.options = {{"mixture", "3"}};
  build(store(), classes, {.threads = 2, .block_levels = 1});
  LayerRequest both = classes;
  both.sources.push_back({.path = folder_ / "fine.tif"});
  build(store(), both, {.threads = 2, .block_levels = 1, .update = true});
  build(folder_ / "both.vts", both, {.threads = 1, .block_levels = 1});
  for (const char* part : {"material", "material/classes", "material/weights", "material/carry"})
    EXPECT_TRUE(tiles_of(store(), part) == tiles_of(folder_ / "both.vts", part)) << part;
  build(store(), classes, {.threads = 2, .block_levels = 1, .update = true});
  build(folder_ / "one.vts", classes, {.threads = 1, .block_levels = 1});
  for (const char* part : {"material", "material/classes", "material/weights", "material/carry"})
    EXPECT_TRUE(tiles_of(store(), part) == tiles_of(folder_ / "one.vts", part)) << part;
}

// What was begun by other rules is not gone on with.
TEST_F(UpdateOfCoarser, TheRulesAreAmongTheFactsOfTheSources) {
  write({.width = 100, .height = 80}, [](auto, auto, int) { return 9.0; });
  const auto plan = plan_layer(request(ChannelType::kColor, 5.0), std::nullopt, std::size_t{1} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  EXPECT_EQ(plan->settings["sources"][0]["resampling_rules"], resample::kWarpRules);
  const auto aligned = plan_layer(request_for({folder_ / "in.tif"}, ChannelType::kColor), std::nullopt, std::size_t{1} << 20);
  EXPECT_FALSE(aligned->settings["sources"][0].contains("resampling_rules"));
}

}  // namespace
}  // namespace vt::pipeline
