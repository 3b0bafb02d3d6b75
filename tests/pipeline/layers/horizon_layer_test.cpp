// Whole layers of horizons: how well the stored mean and deviation tell which share of a coarse texel the sun
// reaches.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "builder/channels/horizon/lit_fraction.h"
#include "tests/pipeline/layer_values.h"

namespace vt::pipeline {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180.0;
constexpr std::int64_t kWidth = 256;
constexpr std::int64_t kMargin = 256;  // of terrain on either side, so that the edge of the raster is none of the terrain
constexpr double kSpacing_m = 10.0;

double height_m(double x, double y) {
  double height = 0.0;
  for (int octave = 0; octave < 6; ++octave) {
    const double wave = 0.023 * std::pow(2.0, octave);  // radians per sample
    const double turn = 1.3 * octave + 0.4;
    height += 90.0 / std::pow(1.7, octave) * std::sin(wave * (x * std::cos(turn) + y * std::sin(turn)) + octave) *
              std::cos(0.8 * wave * (y * std::cos(turn) - x * std::sin(turn)));
  }
  return height;
}

// East and west of every texel, by looking at every sample of its row.
struct Horizons {
  std::vector<std::array<double, 2>> of_texel;  // row by row

  [[nodiscard]] double at(std::int64_t x, std::int64_t y, int direction) const {
    return of_texel[static_cast<std::size_t>(y * kWidth + x)][static_cast<std::size_t>(direction)];
  }
};

const Horizons& terrain() {
  static const Horizons made = [] {
    Horizons horizons;
    std::vector<double> row(static_cast<std::size_t>(kWidth + 2 * kMargin));
    for (std::int64_t y = 0; y < kWidth; ++y) {
      for (std::size_t i = 0; i < row.size(); ++i)
        row[i] = height_m(static_cast<double>(i) - static_cast<double>(kMargin), static_cast<double>(y));
      for (std::int64_t x = 0; x < kWidth; ++x) {
        std::array<double, 2> steepest{-1e9, -1e9};
        for (std::int64_t step = 1; step <= kMargin; ++step)
          for (const int sign : {1, -1}) {
            const double rise = row[static_cast<std::size_t>(x + kMargin + sign * step)] - row[static_cast<std::size_t>(x + kMargin)];
            double& best = steepest[sign == 1 ? 0 : 1];
            best = std::max(best, rise / (static_cast<double>(step) * kSpacing_m));
          }
        horizons.of_texel.push_back({std::atan(steepest[0]), std::atan(steepest[1])});
      }
    }
    return horizons;
  }();
  return made;
}

struct BuiltHorizons {
  test::TempFolder folder;
  std::filesystem::path store;
};

void build_horizons(BuiltHorizons& built, const RasterSpec& spec, TexelFormat format,
                    const std::function<double(std::int64_t, std::int64_t, int)>& value, const channels::Options& options = {}) {
  write_raster(built.folder / "input.tif", spec, value);
  LayerRequest request = request_for({built.folder / "input.tif"}, ChannelType::kHorizon);
  request.format = format;
  request.options = options;
  built.store = built.folder / "a.vts";
  build(built.store, request);
}

constexpr RasterSpec kTerrainRaster{.width = kWidth, .height = kWidth, .bands = 2, .type = SampleType::kFloat32};

double terrain_angle(std::int64_t x, std::int64_t y, int band) { return terrain().at(x, y, band); }

// Mean over texels, both directions and the sun's elevations from 1 to 30 degrees of |lit fraction - truth|.
struct LitErrors {
  double with_deviation = 0.0;
  double mean_alone = 0.0;
};

LitErrors lit_errors(Values& values, int steps) {
  LitErrors errors;
  const std::int64_t block = std::int64_t{1} << steps;
  std::int64_t count = 0;
  for (std::int64_t y = 0; y < kWidth / block; ++y)
    for (std::int64_t x = 0; x < kWidth / block; ++x) {
      const auto stored = values.at(steps, x, y);
      for (int d = 0; d < 2; ++d)
        for (double sun_deg = 1.0; sun_deg <= 30.0; sun_deg += 2.0) {
          const double sun = sun_deg * kOneDegree;
          double truth = 0.0;
          for (std::int64_t j = 0; j < block; ++j)
            for (std::int64_t i = 0; i < block; ++i)
              truth += channels::lit_fraction(sun, terrain().at(x * block + i, y * block + j, d), 0.0);
          truth /= static_cast<double>(block * block);
          const double mean = stored[static_cast<std::size_t>(2 * d)];
          errors.with_deviation += std::abs(channels::lit_fraction(sun, mean, stored[static_cast<std::size_t>(2 * d + 1)]) - truth);
          errors.mean_alone += std::abs(channels::lit_fraction(sun, mean, 0.0) - truth);
          ++count;
        }
    }
  errors.with_deviation /= static_cast<double>(count);
  errors.mean_alone /= static_cast<double>(count);
  return errors;
}

// Methods: the normal distribution of mean and deviation is nearer to the truth than the mean angle alone at
// every level: less than half as far off where a texel holds sixteen and more.
TEST(HorizonLayer, MeanAndDeviationTellTheLitFractionBetterThanTheMeanAngle) {
  BuiltHorizons built;
  build_horizons(built, kTerrainRaster, TexelFormat::kRgba16, terrain_angle);
  Values values(built.store, "horizon");
  for (int steps = 1; steps <= 3; ++steps) {
    const LitErrors errors = lit_errors(values, steps);
    RecordProperty("level_" + std::to_string(steps) + "_with_deviation", std::to_string(errors.with_deviation));
    RecordProperty("level_" + std::to_string(steps) + "_mean_alone", std::to_string(errors.mean_alone));
    EXPECT_LT(errors.with_deviation, (steps == 1 ? 0.6 : 0.45) * errors.mean_alone) << "level " << steps;
  }
  // At the finest level nothing is lost but half a step of 0.0027 degrees: a hundredth of the sun's
  // deviation, whose density is 0.4.
  EXPECT_LT(lit_errors(values, 0).with_deviation, 0.01 * 0.4 * 1.1);
}

TEST(HorizonLayer, EveryLevelHoldsTheMomentsOfTheFinest) {
  BuiltHorizons built;
  build_horizons(built, kTerrainRaster, TexelFormat::kRgba16, terrain_angle);
  Values values(built.store, "horizon");
  for (int steps = 0; steps <= 3; ++steps) {
    const std::int64_t block = std::int64_t{1} << steps;
    for (std::int64_t y = 0; y < kWidth / block; y += 3)
      for (std::int64_t x = 0; x < kWidth / block; x += 3)
        for (int d = 0; d < 2; ++d) {
          double mean = 0.0;
          double square = 0.0;
          for (std::int64_t j = 0; j < block; ++j)
            for (std::int64_t i = 0; i < block; ++i) {
              const double angle = terrain().at(x * block + i, y * block + j, d);
              mean += angle / static_cast<double>(block * block);
              square += angle * angle / static_cast<double>(block * block);
            }
          const auto stored = values.at(steps, x, y);
          EXPECT_NEAR(stored[static_cast<std::size_t>(2 * d)], mean, 0.51 * values.info().components[0].scale + 1e-7);
          // Half a step, and the rounding of float moments: 0.0003 of the angle.
          EXPECT_NEAR(stored[static_cast<std::size_t>(2 * d + 1)], std::sqrt(std::max(0.0, square - mean * mean)),
                      0.51 * values.info().components[1].scale + 3e-4 * std::abs(mean) + 1e-7);
        }
  }
}

TEST(HorizonLayer, EveryLevelReportsTheErrorOfTheLitFraction) {
  const auto lit_error = [](TexelFormat format, const channels::Options& options) {
    BuiltHorizons built;
    build_horizons(built, kTerrainRaster, format, terrain_angle, options);
    const auto metadata = nlohmann::json::parse(Values(built.store, "horizon").info().metadata_json);
    EXPECT_EQ(metadata["unit"], "rad");
    EXPECT_EQ(metadata["azimuths_deg"][0], 90.0);
    EXPECT_EQ(metadata["quality"][0]["name"], "lit fraction");
    EXPECT_EQ(metadata["quality"][1]["unit"], "deg");
    EXPECT_EQ(metadata["quality"][0]["levels"][0]["measured"], 2 * kWidth * kWidth) << "both directions of every texel";
    const double mean = metadata["quality"][0]["levels"][0]["mean"].get<double>();
    RecordProperty(std::string(format_info(format).name) + (options.empty() ? "" : "_span"), std::to_string(mean));
    return mean;
  };
  const double in_16 = lit_error(TexelFormat::kRgba16, {});
  const double in_8 = lit_error(TexelFormat::kRgba8, {});
  const double in_8_low = lit_error(TexelFormat::kRgba8, {{"span", "-10,50"}});
  const double in_blocks_low = lit_error(TexelFormat::kBc5, {{"span", "-10,50"}});
  EXPECT_LT(in_16, 0.01 * in_8);
  EXPECT_LT(in_8_low, 0.5 * in_8);
  EXPECT_LT(in_8_low, in_blocks_low) << "blocks err more than plain codes of the same span";
}

TEST(HorizonLayer, LevelGroundIsExactlyLevelAtEveryLevelAndHolesStayHoles) {
  BuiltHorizons built;
  const auto holes = [](std::int64_t x, std::int64_t y) { return x >= 32 && x < 64 && y < 32; };  // a whole tile, and its coarser texels
  build_horizons(built, {.width = 100, .height = 70, .bands = 2, .type = SampleType::kFloat32}, TexelFormat::kRgba16,
                 [&](std::int64_t x, std::int64_t y, int) { return holes(x, y) ? std::nan("") : 0.0; });
  Values values(built.store, "horizon");
  EXPECT_TRUE(values.info().zero_is_nodata);
  for (int steps = 0; steps <= values.info().finest.value; ++steps)
    EXPECT_EQ(values.at(steps, 5 >> steps, 40 >> steps), (std::array<double, 4>{0.0, 0.0, 0.0, 0.0})) << steps;
  const double no_data = values.info().components[0].offset;  // code 0
  EXPECT_EQ(values.at(1, 20, 5)[0], no_data);
  EXPECT_EQ(values.at(1, 32, 5)[0], 0.0);
}

TEST(HorizonLayer, HowItIsCutIntoBlocksShowsInNoPart) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 301, .height = 203, .bands = 6, .type = SampleType::kFloat32},
               [](std::int64_t x, std::int64_t y, int band) {
                 return (x / 9 + y / 7) % 5 == 0 ? std::nan("") : (hash_noise(x, y, band) % 1000) / 1000.0 - 0.2;
               });
  const LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kHorizon);
  build(folder / "whole.vts", request, {.threads = 1, .block_levels = 4});
  build(folder / "blocks.vts", request, {.threads = 2, .block_levels = 1});
  for (const char* name : {"horizon", "horizon/az120-south", "horizon/az240-az300"})
    EXPECT_TRUE(tiles_of(folder / "whole.vts", name) == tiles_of(folder / "blocks.vts", name)) << name;
}

TEST(HorizonLayer, DegenerateInputsBuild) {
  const double nan = std::nan("");
  const std::vector<std::array<std::int64_t, 2>> sizes{{1, 1}, {1, 70}, {70, 1}, {31, 33}, {64, 65}};
  const std::vector<std::function<double(std::int64_t, std::int64_t, int)>> contents{
      [&](std::int64_t, std::int64_t, int) { return nan; },
      [&](std::int64_t x, std::int64_t y, int) { return x == 0 && y == 0 ? 1.0 : nan; },
      [&](std::int64_t x, std::int64_t, int) { return x % 2 == 0 ? 1e30 : -1e30; }, [&](std::int64_t, std::int64_t, int) { return 1e-42; },
      [&](std::int64_t x, std::int64_t y, int) { return ((x + y) % 2 == 0 ? 90.0 : -90.0) * kOneDegree; }};
  for (const auto& size : sizes)
    for (std::size_t content = 0; content < contents.size(); ++content)
      for (const TexelFormat format : {TexelFormat::kRgba16, TexelFormat::kBc5}) {
        BuiltHorizons built;
        build_horizons(built, {.width = size[0], .height = size[1], .bands = 2, .type = SampleType::kFloat32}, format, contents[content]);
        const bool has_data = content != 0 && content != 2;
        const Tiles tiles = tiles_of(built.store, "horizon");
        EXPECT_EQ(!tiles.empty(), has_data) << size[0] << " x " << size[1] << ", content " << content;
        if (content == 4 && format == TexelFormat::kRgba16 && size[0] == 64) {
          // Half at either end: mean 0, and a deviation of 90 degrees, which is clamped to 45.
          Values values(built.store, "horizon");
          EXPECT_NEAR(values.at(1, 3, 3)[0], 0.0, 1e-6);
          EXPECT_NEAR(values.at(1, 3, 3)[1], 45.0 * kOneDegree, 1e-6);
        }
      }
}

}  // namespace
}  // namespace vt::pipeline
