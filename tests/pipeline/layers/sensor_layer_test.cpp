// Sensor layers as a whole: the mean radiance is the same on every level, whatever is stored, and real
// thermal rasters go through.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <nlohmann/json.hpp>

#include "builder/channels/sensor/planck.h"
#include "builder/channels/sensor/thermal_basis.h"
#include "store/texel/texel_decoder.h"
#include "tests/channels/thermal_fixture.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using Value = std::function<double(std::int64_t, std::int64_t, int)>;

struct BuiltSensor {
  LayerInfo layer;
  std::vector<std::vector<double>> values;  // by level, those inside the data; NaN for none
  nlohmann::json metadata;
};

BuiltSensor built(const std::filesystem::path& input, const channels::Options& options, TexelFormat format, int tile,
                  const std::optional<Area>& area = {}, std::optional<double> nodata = {}) {
  const test::TempFolder folder;
  LayerRequest request = request_for({input}, ChannelType::kSensor);
  if (nodata) request.sources[0].nodata = {*nodata};
  request.format = format;
  request.tile_texels = tile;
  request.options = options;
  request.area = area;
  build(folder / "a.vts", request);
  BuiltSensor result;
  auto reader = store::StoreReader::open(folder / "a.vts");
  result.layer = *reader->find_layer("sensor");
  result.metadata = nlohmann::json::parse(result.layer.metadata_json);
  result.values.resize(result.layer.finest.value + std::size_t{1});
  std::vector<float> texels(static_cast<std::size_t>(tile * tile));
  for (const auto& [id, payload] : tiles_of(folder / "a.vts", "sensor")) {
    store::decode_texels(format, payload, static_cast<std::size_t>(tile), static_cast<std::size_t>(tile), texels);
    const TexelRect tile_rect = rect_of(id, result.layer.tile_exponent);
    const TexelRect data = intersect(tile_rect, result.layer.data_rect(id.level));
    for (std::int64_t y = data.y; y < data.bottom(); ++y)
      for (std::int64_t x = data.x; x < data.right(); ++x) {
        const float sample = texels[static_cast<std::size_t>((y - tile_rect.y) * tile + x - tile_rect.x)];
        const bool is_hole = result.layer.zero_is_nodata && sample == 0.0F;
        result.values[id.level.value].push_back(is_hole ? std::nan("")
                                                        : result.layer.components[0].offset + result.layer.components[0].scale * sample);
      }
  }
  return result;
}

BuiltSensor built_of(const RasterSpec& spec, const Value& value, const channels::Options& options, TexelFormat format, int tile,
                     const std::optional<Area>& area = {}) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", spec, value);
  return built(folder / "input.tif", options, format, tile, area);
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return sum / static_cast<double>(count);
}

const channels::BandRadiance& medium_wave() {
  static const channels::BandRadiance band({{3.0, 1.0}, {5.0, 1.0}});
  return band;
}

double kelvins(std::int64_t x, std::int64_t y, int) { return 240.0 + hash_noise(x, y, 7) % 1200 * 0.1; }

TEST(SensorLayer, TheMeanRadianceIsTheSameOnEveryLevelInEveryFormat) {
  const RasterSpec spec{.width = 256, .height = 128, .bands = 1, .type = SampleType::kFloat32};
  double truth = 0.0;
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 256; ++x) truth += medium_wave().radiance(static_cast<float>(kelvins(x, y, 0))) / (256 * 128);
  for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16, TexelFormat::kBc4}) {
    const BuiltSensor layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "0,14"}}, format, 4);
    ASSERT_GE(layer.values.size(), 7U);
    for (std::size_t level = 0; level < layer.values.size(); ++level)
      EXPECT_NEAR(mean_of(layer.values[level]) / truth, 1.0, 0.001) << format_info(format).name << " level " << level;
  }
  // Stored as temperature the same mean comes out, once turned back.
  const BuiltSensor layer = built_of(
      spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "230,370"}, {"store", "temperature"}}, TexelFormat::kR16, 4);
  for (const std::vector<double>& level : layer.values) {
    std::vector<double> radiance;
    for (const double kelvin : level) radiance.push_back(medium_wave().radiance(kelvin));
    EXPECT_NEAR(mean_of(radiance) / truth, 1.0, 0.001);
  }
}

TEST(SensorLayer, TwentyLevelsKeepTheMeanOfASmallPlaceInALargeArea) {
  const RasterSpec spec{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  const Area area{500000.0, 5400000.0 - 2.0 * 64, 500000.0 + std::ldexp(2.0, 21), 5400000.0};
  const BuiltSensor layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}}, TexelFormat::kR32Float, 4, area);
  ASSERT_EQ(layer.values.size(), 20U);
  const double finest = mean_of(layer.values.back());
  // Texels without data do not count, so the mean stays; each level rounds once to float.
  for (const std::vector<double>& level : layer.values) EXPECT_NEAR(mean_of(level) / finest, 1.0, 20 * std::ldexp(1.0, -24));
}

// The void of a raster that does not declare it, as people find them: the largest float. Four of them have no
// sum.
TEST(SensorLayer, AnInfiniteSumIsAnErrorThatSaysWhatToDo) {
  const RasterSpec spec{.width = 48, .height = 40, .bands = 1, .type = SampleType::kFloat32};
  constexpr double kLargest = std::numeric_limits<float>::max();
  const Value holed = [](std::int64_t x, std::int64_t y, int band) {
    return x >= 10 && x < 14 && y >= 10 && y < 14 ? kLargest : kelvins(x, y, band);
  };
  const test::TempFolder folder;
  write_raster(folder / "input.tif", spec, holed);
  for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16, TexelFormat::kBc4}) {
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kSensor);
    request.format = format;
    request.options = {{"span", "0,1000"}};
    const auto built_one = try_build(folder / (std::string(format_info(format).name) + ".vts"), request);
    ASSERT_FALSE(built_one.has_value()) << format_info(format).name;
    EXPECT_EQ(built_one.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(built_one.error().message.find("too large to add; if they are none, say with `nodata`"), std::string::npos)
        << built_one.error().message;
  }
  // What it says helps.
  const BuiltSensor layer = built(folder / "input.tif", {}, TexelFormat::kR32Float, 8, {}, kLargest);
  for (const std::vector<double>& level : layer.values)
    for (const double value : level) EXPECT_TRUE(std::isnan(value) || value < 400.0);
}

// Doubles, and integers that no float is: means over all finest samples in long double, level by level. A
// code is off by half of its step; what is reported is that, not less.
TEST(SensorLayer, WideSamplesAreAveragedAndReportedInDoublePrecision) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 64, .height = 32, .bands = 1, .type = SampleType::kFloat64};
  const Value waves = [](std::int64_t x, std::int64_t y, int) {
    return 1e6 + 1e-3 * std::sin(static_cast<double>(x) / 3.0) + 1e-3 * std::cos(static_cast<double>(y) / 4.0);
  };
  write_raster(folder / "input.tif", spec, waves);
  const BuiltSensor layer = built(folder / "input.tif", {{"span", "999999.99,1000000.01"}, {"unit", "x"}}, TexelFormat::kR16, 4);
  const double step = layer.layer.components[0].scale;
  ASSERT_LT(step, 3.1e-7);
  for (std::size_t level = 0; level < layer.values.size(); ++level) {
    const int steps = layer.layer.finest.value - static_cast<int>(level);
    double largest = 0.0;
    std::vector<double> wanted;
    for (std::int64_t y = 0; y < 32 >> steps; ++y)
      for (std::int64_t x = 0; x < 64 >> steps; ++x) {
        long double sum = 0.0L;
        for (std::int64_t fy = y << steps; fy < (y + 1) << steps; ++fy)
          for (std::int64_t fx = x << steps; fx < (x + 1) << steps; ++fx) sum += static_cast<long double>(waves(fx, fy, 0));
        wanted.push_back(static_cast<double>(sum / std::ldexp(1.0L, 2 * steps)));
      }
    if (wanted.empty()) continue;
    std::vector<double> is = layer.values[level];
    ASSERT_EQ(is.size(), wanted.size());
    std::sort(is.begin(), is.end());
    std::sort(wanted.begin(), wanted.end());
    for (std::size_t i = 0; i < is.size(); ++i) {
      EXPECT_NEAR(is[i], wanted[i], 0.5 * step + 1e-8) << "level " << level;
      largest = std::max(largest, std::abs(is[i] - wanted[i]));
    }
    const auto& rows = layer.metadata.at("quality").at(0).at("levels");
    const auto& row = rows.at(static_cast<std::size_t>(steps));
    EXPECT_GT(row.at("max").get<double>(), 0.5 * largest);
    EXPECT_LE(row.at("max").get<double>(), 0.5 * step + 1e-8);
  }
}

// Said once, at the end of the build, with a count and a place, also when the build was interrupted and what
// was cut off lay in the part that an earlier run had done.
TEST(SensorLayer, WhatIsCutOffIsSaidWhileBuilding) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 300, .height = 200, .bands = 1, .type = SampleType::kFloat32};
  const Value reflectance = [](std::int64_t x, std::int64_t y, int) { return x == 250 && y < 100 ? 1.5 : x == 3 && y == 7 ? -1.0 : 0.5; };
  write_raster(folder / "input.tif", spec, reflectance);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kSensor);
  request.format = TexelFormat::kR16;
  request.options = {{"quantity", "reflectance"}};
  const std::string wanted =
      "layer 'sensor': in 101 texels of the finest level (first in 250,0) the value lies outside 0 to 1, what `span` gives r16, and the "
      "nearer end is stored; give a wider `span`, or use r32f";
  for (const int block_levels : {1, 4}) {
    const auto path = folder / ("whole" + std::to_string(block_levels) + ".vts");
    EXPECT_EQ(build(path, request, {.block_levels = block_levels}).remarks, std::vector<std::string>{wanted});
    const auto metadata = nlohmann::json::parse(store::StoreReader::open(path)->find_layer("sensor")->metadata_json);
    ASSERT_EQ(metadata.at("losses").size(), 1U);
    EXPECT_EQ(metadata.at("losses")[0].at("texels"), 101);
    EXPECT_EQ(metadata.at("losses")[0].at("first"), (std::vector<int>{250, 0}));
  }
  {
    std::atomic<bool> cancel{false};
    BuildOptions options{.threads = 1, .block_levels = 1, .cancel = &cancel};
    options.progress = [&](std::uint64_t done, std::uint64_t total) { cancel = cancel || done * 10 >= total * 8; };
    const auto stopped = try_build(folder / "stopped.vts", request, options);
    ASSERT_FALSE(stopped.has_value());
    EXPECT_EQ(build(folder / "stopped.vts", request).remarks, std::vector<std::string>{wanted});
  }
  // After an update that takes them away there is nothing to say.
  write_raster(folder / "input.tif", spec, [](std::int64_t, std::int64_t, int) { return 0.25; });
  EXPECT_TRUE(build(folder / "whole1.vts", request, {.update = true}).remarks.empty());
  EXPECT_FALSE(
      nlohmann::json::parse(store::StoreReader::open(folder / "whole1.vts")->find_layer("sensor")->metadata_json).contains("losses"));
}

TEST(SensorLayer, AFireOfOnePercentIsSeenInTheMediumWave) {
  // 41 of 64 x 64 texels burn: 1 % of the area at 800 K among 300 K.
  const RasterSpec spec{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  const Value fire = [](std::int64_t x, std::int64_t y, int) { return x * 64 + y < 41 ? 800.0 : 300.0; };
  const BuiltSensor layer =
      built_of(spec, fire, {{"quantity", "temperature"}, {"band", "3,5"}, {"store", "temperature"}}, TexelFormat::kR32Float, 4);
  const double share = 41.0 / 4096;
  const double wanted = medium_wave().temperature(share * medium_wave().radiance(800.0) + (1 - share) * medium_wave().radiance(300.0));
  std::vector<double> radiance;
  for (const double kelvin : layer.values.front()) radiance.push_back(medium_wave().radiance(kelvin));
  const double kelvin = medium_wave().temperature(mean_of(radiance));
  EXPECT_NEAR(kelvin, wanted, 1e-3);
  EXPECT_GT(kelvin, 300.0 + share * 500.0 + 89.0) << "the mean of temperatures would miss 90 K of it";
}

TEST(SensorLayer, ErrorsAreReportedInTheLayersUnitAndInKelvins) {
  const RasterSpec spec{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  const BuiltSensor layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "0,5"}}, TexelFormat::kR16, 16);
  EXPECT_EQ(layer.metadata.at("quantity"), "radiance");
  EXPECT_EQ(layer.metadata.at("band_um"), (std::vector<double>{3.0, 5.0}));
  const auto& quality = layer.metadata.at("quality");
  EXPECT_EQ(quality.at(0).at("name"), "radiance");
  EXPECT_EQ(quality.at(0).at("unit"), "W/(m2 sr)");
  EXPECT_EQ(quality.at(2).at("unit"), "K");
  const double hottest = medium_wave().radiance(static_cast<float>(240.0 + 1199 * 0.1));
  const double clipped = quality.at(1).at("levels").at(0).at("max");
  EXPECT_GT(clipped, 0.0);
  EXPECT_LE(clipped, hottest - 5.0 + 1e-5);
  EXPECT_LT(quality.at(0).at("levels").at(0).at("kept"), 1.0) << "what was cut off is missing";
}

TEST(SensorLayer, HolesAndDegenerateSizesBuild) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 65}, {65, 1}, {33, 31}}) {
    const RasterSpec spec{.width = width, .height = height, .bands = 1, .type = SampleType::kFloat32};
    for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16, TexelFormat::kBc4}) {
      const channels::Options options{{"quantity", "temperature"}, {"band", "3,5"}, {"span", "100,400"}, {"store", "temperature"}};
      const auto check = [&](const Value& value) {
        const BuiltSensor layer = built_of(spec, value, options, format, 4);
        for (const std::vector<double>& level : layer.values)
          for (const double kelvin : level) EXPECT_TRUE(std::isnan(kelvin) || (kelvin >= 99.99 && kelvin <= 400.01)) << kelvin;
      };
      check([](std::int64_t, std::int64_t, int) { return std::nan(""); });
      check([](std::int64_t x, std::int64_t y, int) { return x + y == 0 ? 290.0 : static_cast<double>(INFINITY); });
      check([](std::int64_t x, std::int64_t, int) { return x % 2 == 0 ? 1e30 : 1e-40; });
      check(kelvins);
    }
  }
}

// Half of the area is class 3, the other half class 17, pixel by pixel: at the coarsest level their curves
// are mixed, at every hour.
TEST(SensorLayer, AThermalBasisGivesTheMixturesTemperatureAtEveryHour) {
  const test::TempFolder folder;
  write_raster(folder / "classes.tif", {.width = 64, .height = 64, .bands = 1},
               [](std::int64_t x, std::int64_t y, int) { return (x + y) % 2 == 0 ? 3.0 : 17.0; });
  LayerRequest request = request_for({folder / "classes.tif"}, ChannelType::kSensor);
  request.format = TexelFormat::kRgba16;
  request.tile_texels = 16;
  request.options = {{"basis", test::thermal_library_json()}, {"band", "8,12"}, {"components", "5"}};
  build(folder / "a.vts", request);

  const channels::BandRadiance band({{8.0, 1.0}, {12.0, 1.0}});
  const channels::ThermalLibrary library = channels::parse_thermal_library(test::thermal_library_json(), &band).value();
  auto reader = store::StoreReader::open(folder / "a.vts");
  const LayerInfo* first = reader->find_layer("sensor");
  const LayerInfo* fifth = reader->find_layer("sensor/c5");
  ASSERT_NE(first, nullptr);
  ASSERT_NE(fifth, nullptr);
  EXPECT_TRUE(first->zero_is_nodata);
  // All that a reader has: what is stored and the metadata.
  const auto metadata = nlohmann::json::parse(first->metadata_json);
  channels::ThermalBasis basis;
  metadata.at("basis").at("hours").get_to(basis.hours);
  metadata.at("basis").at("mean").get_to(basis.mean);
  metadata.at("basis").at("curves").get_to(basis.curves);
  const double error = metadata.at("basis").at("error").at("max");

  const auto four = texel_at<std::uint16_t, 4>(tiles_of(folder / "a.vts", "sensor"), 4, Level{0}, 5, 5);
  const auto one = texel_at<std::uint16_t, 1>(tiles_of(folder / "a.vts", "sensor/c5"), 4, Level{0}, 5, 5);
  std::vector<double> c;
  for (std::size_t k = 0; k < 4; ++k) c.push_back(first->components[k].offset + first->components[k].scale * four[k]);
  c.push_back(fifth->components[0].offset + fifth->components[0].scale * one[0]);
  for (std::size_t t = 0; t < library.hours.size(); ++t) {
    const double wanted = band.temperature((library.classes[2].radiance[t] + library.classes[16].radiance[t]) / 2.0);
    EXPECT_NEAR(band.temperature(channels::reconstruct(basis, c, library.hours[t])), wanted, error + 0.02) << library.hours[t] << " h";
  }
}

TEST(SensorLayer, ClassesOfABasisAreNeverInterpolated) {
  LayerRequest request = request_for({}, ChannelType::kSensor);
  request.options = {{"basis", test::thermal_library_json()}, {"band", "8,12"}};
  request.resample = resample::Method::kBilinear;
  const auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  ASSERT_FALSE(plan.has_value());
  EXPECT_NE(plan.error().message.find("they use nearest"), std::string::npos) << plan.error().message;
}

TEST(SensorLayer, RealThermalBandsKeepTheirMeanRadiance) {
  const std::filesystem::path folder = std::filesystem::path(VT_TEST_DATA) / "sensor";
  if (!std::filesystem::exists(folder / "elkton_L8-B10.tiff")) GTEST_SKIP() << "no thermal rasters in " << folder;
  // Landsat 8 band 10: spectral radiance 3.342e-4 DN + 0.1 W/(m2 sr um), over 0.59 um. 0 is no data.
  const BuiltSensor layer =
      built(folder / "elkton_L8-B10.tiff",
            {{"band", "10.6,11.19"}, {"store", "temperature"}, {"input-scale", "1.97178e-4"}, {"input-offset", "0.059"}},
            TexelFormat::kR32Float, 4, {}, 0.0);
  const channels::BandRadiance band({{10.6, 1.0}, {11.19, 1.0}});
  std::vector<double> means;
  for (const std::vector<double>& level : layer.values) {
    std::vector<double> radiance;
    for (const double kelvin : level) {
      if (!std::isnan(kelvin)) {
        EXPECT_GT(kelvin, 200.0);
        EXPECT_LT(kelvin, 350.0);
      }
      radiance.push_back(std::isnan(kelvin) ? kelvin : band.radiance(kelvin));
    }
    means.push_back(mean_of(radiance));
  }
  // The edges' texels cover less than a whole one; down to 16 of them that shifts the mean by less than 1 %,
  // of whole ones nothing.
  EXPECT_NEAR(means.end()[-2] / means.back(), 1.0, 0.001);
  EXPECT_NEAR(means[1] / means.back(), 1.0, 0.01);
  for (const auto& row : layer.metadata.at("quality").at(0).at("levels")) EXPECT_NEAR(row.at("kept").get<double>(), 1.0, 1e-6);
}

}  // namespace
}  // namespace vt::pipeline
