// Light maps as whole layers: the total of light is the same on every level, and what a format cuts off is
// said.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "store/texel/texel_decoder.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using Light = std::function<double(std::int64_t, std::int64_t, int)>;

struct BuiltLight {
  LayerInfo layer;
  std::vector<double> totals;  // of light times coverage times area in base texels, by level
};

BuiltLight built(const RasterSpec& spec, const Light& light, TexelFormat format, int tile, const std::optional<Area>& area = {}) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", spec, light);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kIllumination);
  request.format = format;
  request.tile_texels = tile;
  request.area = area;
  build(folder / "a.vts", request);
  auto reader = store::StoreReader::open(folder / "a.vts");
  BuiltLight result;
  result.layer = *reader->find_layer("illumination");
  const std::size_t channels = format_info(format).channels;
  const auto edge = static_cast<std::size_t>(tile);
  result.totals.resize(result.layer.finest.value + std::size_t{1});
  std::vector<float> texels(edge * edge * channels);
  for (const auto& [id, payload] : tiles_of(folder / "a.vts", "illumination")) {
    store::decode_texels(format, payload, edge, edge, texels);
    const TexelRect tile_rect = rect_of(id, result.layer.tile_exponent);
    const TexelRect data = intersect(tile_rect, result.layer.data_rect(id.level));
    double sum = 0.0;
    for (std::int64_t y = data.y; y < data.bottom(); ++y)
      for (std::int64_t x = data.x; x < data.right(); ++x) {
        const float* texel = texels.data() + static_cast<std::size_t>((y - tile_rect.y) * tile + x - tile_rect.x) * channels;
        for (std::size_t c = 0; c < 3; ++c)
          sum += result.layer.components[c].scale * static_cast<double>(texel[c]) * (channels == 4 ? static_cast<double>(texel[3]) : 1.0);
      }
    result.totals[id.level.value] += std::ldexp(sum, 2 * (result.layer.finest.value - id.level.value));
  }
  return result;
}

double total_of(const RasterSpec& spec, const Light& light) {
  double total = 0.0;
  for (std::int64_t y = 0; y < spec.height; ++y)
    for (std::int64_t x = 0; x < spec.width; ++x)
      for (int c = 0; c < 3; ++c) total += static_cast<double>(static_cast<float>(light(x, y, spec.bands == 1 ? 0 : c)));
  return total;
}

constexpr std::array kFormats{TexelFormat::kRgba32Float, TexelFormat::kRgba16Float, TexelFormat::kRgb9e5, TexelFormat::kBc6h};

// The error of one number, relative, at most: 2^-11 for a half, 2^-9 for the mantissa of rgb9e5; end points
// of bc6h are 31 half codes apart, of which 1024 are an octave.
double half_step(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgba16Float:
      return std::ldexp(1.0, -11);
    case TexelFormat::kRgb9e5:
      return std::ldexp(1.0, -9);
    case TexelFormat::kBc6h:
      return 31.0 / 1024 / 2;
    default:
      return 1e-6;
  }
}

// Six decades of light, each octave as frequent as the others.
double lamps(std::int64_t x, std::int64_t y, int band) {
  return std::exp2(static_cast<double>(hash_noise(x, y, band) % 20000) / 1000.0 - 5.0);
}

// Street lamps 10 m above the ground, every 37 m: inverse-square pools with the cosine of incidence, over a
// sky of 1/500 of the brightest.
double pools(std::int64_t x, std::int64_t y, int band) {
  const auto dx = static_cast<double>((x + 11) % 37 - 18);
  const auto dy = static_cast<double>((y + 7) % 37 - 18);
  return 1.0 + (500.0 - 150.0 * band) * 1000.0 / std::pow(dx * dx + dy * dy + 100.0, 1.5);
}

TEST(IlluminationLayer, TheTotalOfLightIsTheSameOnEveryLevelInEveryFormat) {
  for (const auto& [width, height] : {std::pair{256, 256}, {255, 129}, {97, 257}}) {
    const RasterSpec spec{.width = width, .height = height, .type = SampleType::kFloat32};
    for (const TexelFormat format : kFormats) {
      // Decades between neighbours are beyond the two ends of a block; it takes pools of light.
      const Light light = format == TexelFormat::kBc6h ? pools : lamps;
      const double truth = total_of(spec, light);
      const BuiltLight layer = built(spec, light, format, 4);
      ASSERT_GE(layer.totals.size(), 7U);
      for (std::size_t level = 0; level < layer.totals.size(); ++level) {
        // A level of few numbers cannot be better than one of them; from 64 blocks on errors cancel.
        const std::int64_t blocks = layer.layer.tile_rect(Level{static_cast<std::uint8_t>(level)}).width *
                                    layer.layer.tile_rect(Level{static_cast<std::uint8_t>(level)}).height;
        const double rounding = blocks < 64 ? std::max(0.001, half_step(format)) : 0.001;
        EXPECT_NEAR(layer.totals[level] / truth, 1.0, rounding) << format_info(format).name << " " << width << " level " << level;
      }
    }
  }
}

TEST(IlluminationLayer, OneLampInTheDarkKeepsItsLight) {
  const RasterSpec spec{.width = 256, .height = 256, .bands = 1, .type = SampleType::kFloat32};
  const Light lamp = [](std::int64_t x, std::int64_t y, int) { return x == 77 && y == 130 ? 31000.0 : 0.0; };
  for (const TexelFormat format : kFormats) {
    const BuiltLight layer = built(spec, lamp, format, 4);
    for (std::size_t level = 0; level < layer.totals.size(); ++level) {
      EXPECT_NEAR(layer.totals[level] / (3 * 31000.0), 1.0, half_step(format)) << format_info(format).name << " level " << level;
      if (format != TexelFormat::kBc6h) {
        EXPECT_EQ(layer.totals[level], layer.totals.back()) << "a quarter has the same mantissa";
      }
    }
  }
}

TEST(IlluminationLayer, TwentyLevelsKeepTheTotalOfASmallPlaceInALargeArea) {
  // A strip of 2^21 texels of 2 m, of which 61 x 43 have light.
  const RasterSpec spec{.width = 61, .height = 43, .type = SampleType::kFloat32};
  const Area area{500000.0, 5400000.0 - 2.0 * 43, 500000.0 + std::ldexp(2.0, 21), 5400000.0};
  const BuiltLight layer = built(spec, lamps, TexelFormat::kRgba32Float, 4, area);
  ASSERT_EQ(layer.totals.size(), 20U);
  // Each level rounds once to float: 20 * 2^-24 at most.
  for (const double total : layer.totals) EXPECT_NEAR(total / total_of(spec, lamps), 1.0, 2e-6);
}

TEST(IlluminationLayer, LinesOfOneTexelKeepTheirLight) {
  for (const auto& [width, height] : {std::pair{200, 1}, {1, 200}, {1, 1}}) {
    const RasterSpec spec{.width = width, .height = height, .type = SampleType::kFloat32};
    for (const TexelFormat format : kFormats) {
      const Light light = format == TexelFormat::kBc6h ? pools : lamps;
      const BuiltLight layer = built(spec, light, format, 4);
      for (const double total : layer.totals)
        EXPECT_NEAR(total / total_of(spec, light), 1.0, half_step(format)) << format_info(format).name;
    }
  }
}

TEST(IlluminationLayer, WhatIsCutOffIsInTheMetadata) {
  const RasterSpec spec{.width = 16, .height = 16, .bands = 1, .type = SampleType::kFloat32};
  const Light sun = [](std::int64_t x, std::int64_t y, int) { return x == 5 && y == 6 ? 1e6 : 10.0; };
  for (const TexelFormat format : kFormats) {
    const bool clips = format != TexelFormat::kRgba32Float;
    const BuiltLight layer = built(spec, sun, format, 4);
    const auto quality = nlohmann::json::parse(layer.layer.metadata_json).at("quality");
    ASSERT_EQ(quality.at(1).at("name"), "clipped light");
    const auto& finest = quality.at(1).at("levels").at(0);
    const double limit = format == TexelFormat::kRgb9e5 ? 65408.0 : 65504.0;
    EXPECT_EQ(finest.at("max"), clips ? 1e6 - limit : 0.0) << format_info(format).name;
    const double kept = quality.at(0).at("levels").at(0).at("kept");
    EXPECT_NEAR(kept, clips ? (255 * 10.0 + limit) / (255 * 10.0 + 1e6) : 1.0, 1e-3) << format_info(format).name;
    // Spread over 4 x 4 texels it fits, and none is lost.
    const double coarse = quality.at(0).at("levels").at(2).at("kept");
    EXPECT_NEAR(coarse, 1.0, half_step(format)) << format_info(format).name;
  }
}

// Radiance of a night in W/(m2 sr), lamps in 0.3 % of the texels over five decades: in halves' own range it
// is lost, the more so the coarser the level.
double dim_lamps(std::int64_t x, std::int64_t y, int) {
  const std::uint32_t noise = hash_noise(x, y, 0);
  return noise % 1000 < 3 ? 1e-6 * std::exp(static_cast<double>(noise / 1000 % 12000) / 1000.0 - 6.0) : 0.0;
}

TEST(IlluminationLayer, LightInSmallUnitsIsKeptByAScaleThatReadersAreTold) {
  const RasterSpec spec{.width = 256, .height = 256, .bands = 1, .type = SampleType::kFloat32};
  const double truth = total_of(spec, dim_lamps);
  for (const TexelFormat format : kFormats) {
    const BuiltLight layer = built(spec, dim_lamps, format, 4);
    for (std::size_t c = 0; c < 3; ++c) {
      const double scale = layer.layer.components[c].scale;
      EXPECT_EQ(scale == 1.0, format == TexelFormat::kRgba32Float) << format_info(format).name;
      EXPECT_EQ(std::exp2(std::round(std::log2(scale))), scale) << "a power of two";
    }
    EXPECT_EQ(layer.layer.components[3].scale, 1.0);
    for (std::size_t level = 0; level < layer.totals.size(); ++level) {
      // Blocks of one lamp and darkness have ends 31 half codes apart; there are hundreds of them down to
      // level 3.
      const double rounding = format == TexelFormat::kBc6h ? (level > 2 ? 0.002 : half_step(format)) : std::max(0.001, half_step(format));
      EXPECT_NEAR(layer.totals[level] / truth, 1.0, rounding) << format_info(format).name << " level " << level;
    }
  }
}

// As small as floats get: the scale and its reciprocal are floats still.
TEST(IlluminationLayer, TheSmallestLightIsKept) {
  for (const double light : {1e-35, 1e-36, 1e-37}) {
    const BuiltLight small = built(
        {.width = 32, .height = 32, .type = SampleType::kFloat32}, [&](std::int64_t, std::int64_t, int) { return light; },
        TexelFormat::kRgba16Float, 32);
    const double wanted = 3.0 * 32 * 32 * light;
    for (const double total : small.totals) EXPECT_NEAR(total / wanted, 1.0, 1e-3) << light;  // halves have 11 bits
  }
}

TEST(IlluminationLayer, LightThatHalvesHoldHasNoScale) {
  const RasterSpec spec{.width = 97, .height = 131, .type = SampleType::kFloat32};
  for (const TexelFormat format : kFormats)
    for (const Light& light : {Light(lamps), Light(pools), Light([](std::int64_t, std::int64_t, int) { return 0.0; })})
      EXPECT_EQ(built(spec, light, format, 32).layer.components[0].scale, 1.0) << format_info(format).name;
}

TEST(IlluminationLayer, AnUpdateKeepsTheScaleThatTheLayerHas) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 200, .height = 120, .bands = 1, .type = SampleType::kFloat32};
  write_raster(folder / "input.tif", spec, dim_lamps);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kIllumination);
  request.format = TexelFormat::kRgba16Float;
  build(folder / "a.vts", request, {.block_levels = 1});
  const auto scale = [&] { return store::StoreReader::open(folder / "a.vts")->find_layer("illumination")->components[0].scale; };
  const double before = scale();
  ASSERT_LT(before, 1.0);
  // Lamps a hundred thousand times as bright: by themselves they need no scale.
  write_raster(folder / "input.tif", spec,
               [](std::int64_t x, std::int64_t y, int band) { return x < 30 ? 1e5 * dim_lamps(x, y, band) : dim_lamps(x, y, band); });
  build(folder / "a.vts", request, {.update = true});
  EXPECT_EQ(scale(), before);
  // A choice is a setting like any other.
  request.options = {{"stored-scale", "0.5"}};
  const auto other = try_build(folder / "a.vts", request, {.update = true});
  ASSERT_FALSE(other.has_value());
  EXPECT_EQ(other.error().code, ErrorCode::kExists);
  const BuildReport chosen = build(folder / "b.vts", request);
  EXPECT_EQ(store::StoreReader::open(folder / "b.vts")->find_layer("illumination")->components[0].scale, 0.5);
  ASSERT_FALSE(chosen.remarks.empty());
  EXPECT_NE(chosen.remarks.back().find("rgba16f stores nothing in this layer; give a smaller `stored-scale`"), std::string::npos)
      << chosen.remarks.back();
}

TEST(IlluminationLayer, AnInfiniteSumIsAnErrorThatSaysWhatToDo) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 48, .height = 40, .bands = 1, .type = SampleType::kFloat32},
               [](std::int64_t x, std::int64_t y, int) { return x < 4 && y < 4 ? std::numeric_limits<float>::max() : 20.0; });
  for (const TexelFormat format : kFormats) {
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kIllumination);
    request.format = format;
    const auto failed = try_build(folder / (std::string(format_info(format).name) + ".vts"), request);
    ASSERT_FALSE(failed.has_value()) << format_info(format).name;
    EXPECT_EQ(failed.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(failed.error().message.find("`nodata`"), std::string::npos) << failed.error().message;
  }
}

TEST(IlluminationLayer, DarkFramesAndHolesBuild) {
  const float inf = std::numeric_limits<float>::infinity();
  const RasterSpec spec{.width = 33, .height = 31, .bands = 1, .type = SampleType::kFloat32};
  const auto check = [&](const Light& light, double wanted) {
    for (const TexelFormat format : kFormats) {
      const BuiltLight layer = built(spec, light, format, 4);
      for (const double total : layer.totals) EXPECT_NEAR(total, wanted, wanted / 256) << format_info(format).name;
    }
  };
  check([](std::int64_t, std::int64_t, int) { return 0.0; }, 0.0);
  check([](std::int64_t, std::int64_t, int) { return std::nan(""); }, 0.0);
  check([](std::int64_t, std::int64_t, int) { return -5.0; }, 0.0);
  check([](std::int64_t x, std::int64_t y, int) { return x == 9 && y == 30 ? 64.0 : std::nan(""); }, 3 * 64.0);
  check([inf](std::int64_t x, std::int64_t y, int) { return x == 0 && y == 0 ? 64.0 : static_cast<double>(inf); }, 3 * 64.0);
}

}  // namespace
}  // namespace vt::pipeline
