// Sensor layers as a whole: the mean radiance is the same on every level, whatever is stored, and real thermal rasters go through.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "builder/channels/planck.h"
#include "builder/channels/thermal_basis.h"
#include "store/texel_decoder.h"
#include "tests/channels/thermal_fixture.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using Value = std::function<double(std::int64_t, std::int64_t, int)>;

struct Built {
  LayerInfo layer;
  std::vector<std::vector<double>> values;  // by level, those inside the data; NaN for none
  nlohmann::json metadata;
};

Built built(const std::filesystem::path& input, const channels::Options& options, TexelFormat format, int tile,
            const std::optional<Area>& area = {}, std::optional<double> nodata = {}) {
  const test::TempFolder folder;
  LayerRequest request = request_for({input}, ChannelType::kSensor);
  if (nodata) request.sources[0].nodata = {*nodata};
  request.format = format;
  request.tile_texels = tile;
  request.options = options;
  request.area = area;
  build(folder / "a.vts", request);
  Built result;
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

Built built_of(const RasterSpec& spec, const Value& value, const channels::Options& options, TexelFormat format, int tile,
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
    const Built layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "0,14"}}, format, 4);
    ASSERT_GE(layer.values.size(), 7U);
    for (std::size_t level = 0; level < layer.values.size(); ++level)
      EXPECT_NEAR(mean_of(layer.values[level]) / truth, 1.0, 0.001) << format_info(format).name << " level " << level;
  }
  // Stored as temperature the same mean comes out, once turned back.
  const Built layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "230,370"}, {"store", "temperature"}},
                               TexelFormat::kR16, 4);
  for (const std::vector<double>& level : layer.values) {
    std::vector<double> radiance;
    for (const double kelvin : level) radiance.push_back(medium_wave().radiance(kelvin));
    EXPECT_NEAR(mean_of(radiance) / truth, 1.0, 0.001);
  }
}

TEST(SensorLayer, TwentyLevelsKeepTheMeanOfASmallPlaceInALargeArea) {
  const RasterSpec spec{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  const Area area{500000.0, 5400000.0 - 2.0 * 64, 500000.0 + std::ldexp(2.0, 21), 5400000.0};
  const Built layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}}, TexelFormat::kR32Float, 4, area);
  ASSERT_EQ(layer.values.size(), 20U);
  const double finest = mean_of(layer.values.back());
  // Texels without data do not count, so the mean stays; each level rounds once to float.
  for (const std::vector<double>& level : layer.values) EXPECT_NEAR(mean_of(level) / finest, 1.0, 20 * std::ldexp(1.0, -24));
}

TEST(SensorLayer, AFireOfOnePercentIsSeenInTheMediumWave) {
  // 41 of 64 x 64 texels burn: 1 % of the area at 800 K among 300 K.
  const RasterSpec spec{.width = 64, .height = 64, .bands = 1, .type = SampleType::kFloat32};
  const Value fire = [](std::int64_t x, std::int64_t y, int) { return x * 64 + y < 41 ? 800.0 : 300.0; };
  const Built layer =
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
  const Built layer = built_of(spec, kelvins, {{"quantity", "temperature"}, {"band", "3,5"}, {"span", "0,5"}}, TexelFormat::kR16, 16);
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
        const Built layer = built_of(spec, value, options, format, 4);
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

// Half of the area is class 3, the other half class 17, pixel by pixel: at the coarsest level their curves are mixed, at every hour.
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
  const Built layer = built(folder / "elkton_L8-B10.tiff",
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
  // The edges' texels cover less than a whole one; down to 16 of them that shifts the mean by less than 1 %, of whole ones nothing.
  EXPECT_NEAR(means.end()[-2] / means.back(), 1.0, 0.001);
  EXPECT_NEAR(means[1] / means.back(), 1.0, 0.01);
  for (const auto& row : layer.metadata.at("quality").at(0).at("levels")) EXPECT_NEAR(row.at("kept").get<double>(), 1.0, 1e-6);
}

}  // namespace
}  // namespace vt::pipeline
