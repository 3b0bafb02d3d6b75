// Whole layers of normals: what filtering keeps of them, level by level, as it is stored.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/pipeline/layer_values.h"

namespace vt::pipeline {
namespace {

constexpr double kRadiansOfDegree = std::numbers::pi / 180.0;

struct BuiltNormals {
  test::TempFolder folder;
  std::filesystem::path store;
};

void build_normals(BuiltNormals& built, const RasterSpec& spec, TexelFormat format,
                   const std::function<double(std::int64_t, std::int64_t, int)>& value, const channels::Options& options = {}) {
  write_raster(built.folder / "input.tif", spec, value);
  LayerRequest request = request_for({built.folder / "input.tif"}, ChannelType::kNormal);
  request.format = format;
  request.options = options;
  built.store = built.folder / "a.vts";
  build(built.store, request);
}

// Ridges and hills, heights in metres at samples 10 m apart; the normal by analytic slopes.
std::array<double, 3> terrain_normal(double x, double y) {
  double slope_x = 0.0;
  double slope_y = 0.0;
  for (int octave = 0; octave < 7; ++octave) {
    const double wave = 0.012 * std::pow(2.0, octave);  // radians per sample
    const double height = 60.0 / std::pow(1.5, octave);
    const double turn = 1.1 * octave;
    const double along = wave * (x * std::cos(turn) + y * std::sin(turn)) + octave;
    const double across = 0.7 * wave * (y * std::cos(turn) - x * std::sin(turn));
    const double d_along = height * wave / 10.0 * std::cos(along) * std::cos(across);
    const double d_across = -0.7 * height * wave / 10.0 * std::sin(along) * std::sin(across);
    slope_x += d_along * std::cos(turn) - d_across * std::sin(turn);
    slope_y += d_along * std::sin(turn) + d_across * std::cos(turn);
  }
  const double length = std::sqrt(slope_x * slope_x + slope_y * slope_y + 1.0);
  return {-slope_x / length, -slope_y / length, 1.0 / length};
}

double terrain_component(std::int64_t x, std::int64_t y, int band) {
  return terrain_normal(static_cast<double>(x), static_cast<double>(y))[static_cast<std::size_t>(band)];
}

TEST(NormalLayer, StripesOf60DegreesKeepTheirDirectionAndSayHowShortTheirMeanIs) {
  const auto stripes = [](std::int64_t x, std::int64_t, int band) {
    return band == 0 ? (x % 2 == 0 ? 1.0 : -1.0) * std::sin(60.0 * kRadiansOfDegree) : band == 1 ? 0.0 : std::cos(60.0 * kRadiansOfDegree);
  };
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kRg16, TexelFormat::kBc5}) {
    BuiltNormals built;
    build_normals(built, {.width = 64, .height = 64, .type = SampleType::kFloat32}, format, stripes);
    Values direction(built.store, "normal");
    Values length(built.store, "normal/length");
    const double step = length.info().components[0].scale;
    for (std::int64_t x = 0; x < 32; ++x) {
      const auto d = direction.at(1, x, 9);
      EXPECT_EQ(d[0], 0.0) << format_info(format).name;
      EXPECT_EQ(d[1], 0.0) << format_info(format).name;
      if (format == TexelFormat::kRgb8) {
        EXPECT_NEAR(d[2], 1.0, 1e-15);
      }
      EXPECT_NEAR(length.at(1, x, 9)[0], 0.5, 0.5 * step + 1e-6) << format_info(format).name;
    }
  }
}

TEST(NormalLayer, AConstantFieldStaysItselfAtEveryLevelWithLengthOne) {
  const std::array<double, 3> tilted{0.36, 0.48, 0.8};
  BuiltNormals built;
  build_normals(built, {.width = 77, .height = 133, .type = SampleType::kFloat32}, TexelFormat::kRgba16,
                [&](std::int64_t, std::int64_t, int band) { return 3.0 * tilted[static_cast<std::size_t>(band)]; });
  Values values(built.store, "normal");
  for (int steps = 0; steps <= values.info().finest.value; ++steps)
    for (std::int64_t x = 0; x <= (77 - 1) >> steps; ++x) {
      const auto v = values.at(steps, x, 5 >> steps);
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], tilted[c], 0.51 / 32767.0);
      EXPECT_NEAR(v[3], 1.0, 1e-12) << "also at the edges, where part of the texel lies outside";
    }
}

TEST(NormalLayer, EveryLevelIsTheMeanOfTheFinestWithinItsQuantisation) {
  BuiltNormals built;
  build_normals(built, {.width = 256, .height = 256, .type = SampleType::kFloat32}, TexelFormat::kRgba16, terrain_component);
  Values values(built.store, "normal");
  for (int steps = 0; steps <= 3; ++steps) {
    const std::int64_t block = std::int64_t{1} << steps;
    for (std::int64_t y = 0; y < 256 / block; y += 5)
      for (std::int64_t x = 0; x < 256 / block; x += 5) {
        std::array<double, 3> mean{};
        for (std::int64_t j = 0; j < block; ++j)
          for (std::int64_t i = 0; i < block; ++i)
            for (int c = 0; c < 3; ++c)
              mean[static_cast<std::size_t>(c)] += terrain_component(x * block + i, y * block + j, c) / static_cast<double>(block * block);
        const auto v = values.at(steps, x, y);
        // Half a step of the direction, and of the length.
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c] * v[3], mean[c], 0.51 / 32767.0 + 0.51 / 65534.0 + 1e-6);
      }
  }
}

// Methods: shading a coarse level with the mean vector as it is (direction times length) comes nearer to the
// mean of the shading under it than with the direction alone, and the more so the coarser the level.
TEST(NormalLayer, TheLengthBringsShadingNearerToTheMeanOfTheShading) {
  constexpr std::int64_t kWidth = 256;
  std::vector<std::array<double, 3>> normals;
  for (std::int64_t y = 0; y < kWidth; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x) normals.push_back(terrain_normal(static_cast<double>(x), static_cast<double>(y)));
  const auto normal_at = [&](std::int64_t x, std::int64_t y) { return normals[static_cast<std::size_t>(y * kWidth + x)]; };
  BuiltNormals built;
  build_normals(built, {.width = kWidth, .height = kWidth, .type = SampleType::kFloat32}, TexelFormat::kRg16,
                [&](std::int64_t x, std::int64_t y, int band) { return normal_at(x, y)[static_cast<std::size_t>(band)]; });
  Values direction(built.store, "normal");
  Values length(built.store, "normal/length");
  for (const int steps : {1, 2, 3}) {
    const std::int64_t block = std::int64_t{1} << steps;
    double squares_direction = 0.0;
    double squares_mean = 0.0;
    double mean_length = 0.0;
    std::int64_t count = 0;
    for (std::int64_t y = 0; y < kWidth / block; ++y)
      for (std::int64_t x = 0; x < kWidth / block; ++x)
        for (const double sun_azimuth_deg : {20.0, 140.0, 260.0}) {
          const double elevation = 35.0 * kRadiansOfDegree;
          const std::array<double, 3> sun{std::cos(elevation) * std::sin(sun_azimuth_deg * kRadiansOfDegree),
                                          std::cos(elevation) * std::cos(sun_azimuth_deg * kRadiansOfDegree), std::sin(elevation)};
          const auto lambert = [&](const auto& n) { return std::max(0.0, n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2]); };
          double truth = 0.0;
          for (std::int64_t j = 0; j < block; ++j)
            for (std::int64_t i = 0; i < block; ++i) truth += lambert(normal_at(x * block + i, y * block + j));
          truth /= static_cast<double>(block * block);
          auto d = direction.at(steps, x, y);
          d[2] = std::sqrt(std::max(0.0, 1.0 - d[0] * d[0] - d[1] * d[1]));
          const double with_direction = lambert(d);
          const double r = length.at(steps, x, y)[0];
          squares_direction += std::pow(with_direction - truth, 2);
          squares_mean += std::pow(with_direction * r - truth, 2);
          mean_length += r;
          ++count;
        }
    const double rmse_direction = std::sqrt(squares_direction / static_cast<double>(count));
    const double rmse_mean = std::sqrt(squares_mean / static_cast<double>(count));
    RecordProperty("level_" + std::to_string(steps) + "_rmse_direction", std::to_string(rmse_direction));
    RecordProperty("level_" + std::to_string(steps) + "_rmse_mean", std::to_string(rmse_mean));
    RecordProperty("level_" + std::to_string(steps) + "_mean_length", std::to_string(mean_length / static_cast<double>(count)));
    EXPECT_LT(rmse_mean, 0.8 * rmse_direction) << "level " << steps << ": " << rmse_mean << " and " << rmse_direction;
  }
}

TEST(NormalLayer, EveryLevelReportsItsAngles) {
  const auto angles = [](TexelFormat format) {
    BuiltNormals built;
    build_normals(built, {.width = 200, .height = 120, .type = SampleType::kFloat32}, format, terrain_component);
    const auto metadata = nlohmann::json::parse(Values(built.store, "normal").info().metadata_json);
    EXPECT_EQ(metadata["components"][0], "east");
    EXPECT_EQ(metadata["frame"], "enu");
    EXPECT_EQ(metadata["quality"][0]["name"], "direction");
    EXPECT_EQ(metadata["quality"][0]["unit"], "deg");
    EXPECT_EQ(metadata["quality"][1]["name"], "length");
    double largest = 0.0;
    for (const auto& level : metadata["quality"][0]["levels"]) largest = std::max(largest, level["max"].get<double>());
    EXPECT_GT(largest, 0.0);
    RecordProperty(std::string(format_info(format).name) + "_mean_deg",
                   std::to_string(metadata["quality"][0]["levels"][0]["mean"].get<double>()));
    RecordProperty(std::string(format_info(format).name) + "_max_deg", std::to_string(largest));
    return largest;
  };
  EXPECT_LE(angles(TexelFormat::kRgb8), 0.392) << "half a step in each of three components: asin(sqrt(3) / 254)";
  EXPECT_LE(angles(TexelFormat::kRgba16), 0.392 / 256);
  EXPECT_LE(angles(TexelFormat::kRg16), 0.01);
  EXPECT_LE(angles(TexelFormat::kBc5), 15.0) << "the most that was measured for steep terrain at 8 bits a texel";
}

TEST(NormalLayer, HowItIsCutIntoBlocksShowsInNoPart) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 301, .height = 203, .type = SampleType::kFloat32},
               [](std::int64_t x, std::int64_t y, int band) {
                 return (x / 9 + y / 7) % 5 == 0 ? 0.0 : terrain_component(x, y, band);  // with holes, whose neighbours lend directions
               });
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kNormal);
  request.options = {{"moments", "lean"}};
  build(folder / "whole.vts", request, {.threads = 1, .block_levels = 4});
  build(folder / "blocks.vts", request, {.threads = 2, .block_levels = 1});
  for (const char* name : {"normal", "normal/length", "normal/moments", "normal/cross_moment"})
    EXPECT_TRUE(tiles_of(folder / "whole.vts", name) == tiles_of(folder / "blocks.vts", name)) << name;
}

// Sizes and contents at which loops and normalisations break: they build, and nothing is stored that is not a
// direction.
TEST(NormalLayer, DegenerateInputsBuild) {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<std::array<std::int64_t, 2>> sizes{{1, 1}, {1, 70}, {70, 1}, {31, 33}, {64, 65}, {127, 1}};
  const std::vector<std::function<double(std::int64_t, std::int64_t, int)>> contents{
      [&](std::int64_t, std::int64_t, int) { return nan; },
      [&](std::int64_t x, std::int64_t y, int) { return x == 0 && y == 0 ? 1.0 : nan; },
      [&](std::int64_t x, std::int64_t, int band) { return band == 1 && x % 3 == 1 ? inf : 1e30; },
      [&](std::int64_t, std::int64_t, int) { return 1e-42; },
      [&](std::int64_t x, std::int64_t y, int) { return (x + y) % 2 == 0 ? 1.0 : -1.0; }};
  for (const auto& size : sizes)
    for (std::size_t content = 0; content < contents.size(); ++content)
      for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kBc5}) {
        BuiltNormals built;
        build_normals(built, {.width = size[0], .height = size[1], .type = SampleType::kFloat32}, format, contents[content],
                      {{"moments", "lean"}});
        const bool has_data = content != 0 && content != 3;
        const Tiles lengths = tiles_of(built.store, "normal/length");
        EXPECT_EQ(!lengths.empty(), has_data) << size[0] << " x " << size[1] << ", content " << content;
        if (content == 1 && format == TexelFormat::kRgb8) {
          for (const auto& [tile, bytes] : lengths) EXPECT_EQ(static_cast<int>(bytes.front()), 255) << "one valid texel";
        }
      }
}

}  // namespace
}  // namespace vt::pipeline
