// Colour layers as a whole: the mean of light on every level, which format is taken when none is named, what
// an opaque one shows where there are no data.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "builder/channels/shared/srgb.h"
#include "store/texel/texel_decoder.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using Codes = std::function<double(std::int64_t, std::int64_t, int)>;

double light_of(double code) { return channels::linear_from_srgb(code / 255.0); }

// Mean light of each level, over the data; every texel has some.
std::vector<double> mean_light(const std::filesystem::path& store, const LayerInfo& layer) {
  const std::size_t channels = format_info(layer.format).channels;
  const auto edge = static_cast<std::size_t>(layer.tile_texels());
  std::vector<double> sums(layer.finest.value + std::size_t{1});
  std::vector<double> counts(sums.size());
  std::vector<float> texels(edge * edge * channels);
  for (const auto& [id, payload] : tiles_of(store, layer.name)) {
    store::decode_texels(layer.format, payload, edge, edge, texels);
    const TexelRect tile = rect_of(id, layer.tile_exponent);
    const TexelRect data = intersect(tile, layer.data_rect(id.level));
    for (std::int64_t y = data.y; y < data.bottom(); ++y)
      for (std::int64_t x = data.x; x < data.right(); ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const auto at = static_cast<std::size_t>((y - tile.y) * tile.width + x - tile.x) * channels + c;
          sums[id.level.value] += light_of(std::round(static_cast<double>(texels[at])));
          counts[id.level.value] += 1.0;
        }
  }
  for (std::size_t level = 0; level < sums.size(); ++level) sums[level] /= counts[level];
  return sums;
}

LayerInfo layer_of(const std::filesystem::path& store) {
  auto reader = store::StoreReader::open(store);
  EXPECT_TRUE(reader.has_value());
  return *reader->find_layer("color");
}

// Codes from 0 to `most`, correlated like a picture's: every texel near its neighbours, so that means lie
// between neighbouring codes.
Codes dark(int most) {
  return [most](std::int64_t x, std::int64_t y, int band) {
    const double wave = 0.5 + 0.3 * std::sin(0.05 * static_cast<double>(x + 31 * band)) * std::cos(0.04 * static_cast<double>(y)) +
                        0.2 * (hash_noise(x, y, band) % 1000) / 1000.0;
    return std::floor(wave * most);
  };
}

// A sharp kernel rings below black beside a white frame, and codes cut that off: light that was not there. It
// is reported as what it is, and the light that goes on to coarser levels has none of it.
TEST(ColorLayer, WhatSharpKernelsLoseIsInTheReport) {
  const test::TempFolder folder;
  const auto framed = [](std::int64_t x, std::int64_t y, int) { return std::min({x, y, 1023 - x, 1023 - y}) < 3 ? 255.0 : 60.0; };
  write_raster(folder / "input.tif", {.width = 1024, .height = 1024}, framed);
  LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
  request.kernel = "kaiser3";
  request.format = TexelFormat::kRgb8;
  build(folder / "a.vts", request);
  const LayerInfo layer = layer_of(folder / "a.vts");
  const double inner = 1018.0 * 1018 / (1024.0 * 1024);
  const double truth = inner * light_of(60) + (1 - inner) * light_of(255);
  const std::vector<double> means = mean_light(folder / "a.vts", layer);
  const auto rows = nlohmann::json::parse(layer.metadata_json).at("quality").at(0).at("levels");
  ASSERT_EQ(rows.size(), means.size());
  double worst = 0.0;
  for (const auto& row : rows) {
    const double kept = means[row.at("level").get<std::size_t>()] / truth;
    // Light goes on in floats, level after level.
    EXPECT_NEAR(row.at("kept").get<double>(), kept, 2e-5) << "level " << row.at("level");
    worst = std::max(worst, std::abs(kept - 1.0));
  }
  EXPECT_GT(worst, 0.01) << "nothing was cut off";
}

// A level of n numbers in steps of at most half of their light can be off by 0.5 / sqrt(12 n) by chance, of
// 2^14 numbers 0.11 %. On the first coarser level every number is a mean of four whole codes: many lie half
// way between two codes, but for the curve between codes and light, which puts them a little higher, so that
// they become the upper one. Of codes around 19, 4 % of their light apart, that is 0.5 % if a quarter of all
// numbers do; the other levels have means of too many codes for that.
TEST(ColorLayer, TheMeanLightOfDarkPicturesIsKeptOnEveryLevel) {
  for (const int most : {12, 38, 255}) {
    const test::TempFolder folder;
    write_raster(folder / "input.tif", {.width = 1024, .height = 1024}, dark(most));
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
    request.kernel = "box";
    request.format = TexelFormat::kRgb8;
    build(folder / "a.vts", request);
    const LayerInfo layer = layer_of(folder / "a.vts");
    double truth = 0.0;
    for (std::int64_t y = 0; y < 1024; ++y)
      for (std::int64_t x = 0; x < 1024; ++x)
        for (int c = 0; c < 3; ++c) truth += light_of(dark(most)(x, y, c)) / (1024.0 * 1024 * 3);
    const std::vector<double> means = mean_light(folder / "a.vts", layer);
    EXPECT_NEAR(means.back() / truth, 1.0, 1e-10) << "the finest level is the very codes that went in";
    for (int level = layer.finest.value; level >= layer.finest.value - 3; --level)
      EXPECT_NEAR(means[static_cast<std::size_t>(level)] / truth, 1.0, level == layer.finest.value - 1 ? 0.005 : 0.001)
          << "codes to " << most << ", level " << level;
    // And it is what the layer reports.
    const auto rows = nlohmann::json::parse(layer.metadata_json).at("quality").at(0).at("levels");
    for (const auto& row : rows)
      if (row.at("level") >= layer.finest.value - 3) {
        EXPECT_NEAR(row.at("kept").get<double>(), means[row.at("level").get<std::size_t>()] / truth, 2e-5);
      }
  }
}

// Every mean of such a picture lies just half way between two codes.
TEST(ColorLayer, ColumnsOfNeighbouringCodesKeepTheirMeanLight) {
  for (const int code : {2, 20, 100}) {
    const test::TempFolder folder;
    write_raster(folder / "input.tif", {.width = 128, .height = 128}, [&](std::int64_t x, std::int64_t, int) { return code + (x & 1); });
    LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
    request.kernel = "box";
    build(folder / "a.vts", request);
    for (const double mean : mean_light(folder / "a.vts", layer_of(folder / "a.vts")))
      EXPECT_NEAR(mean, 0.5 * (light_of(code) + light_of(code + 1)), 1e-9) << code;
  }
}

// End points of bc1 have 5 and 6 bits: next to black they cannot keep the light, and whoever builds the layer
// is told.
TEST(ColorLayer, LightThatBlocksDoNotKeepIsSaid) {
  const test::TempFolder folder;
  write_raster(folder / "dark.tif", {.width = 512, .height = 512}, dark(12));
  write_raster(folder / "bright.tif", {.width = 512, .height = 512}, dark(255));
  const auto remarks = [&](const std::string& picture, TexelFormat format) {
    LayerRequest request = request_for({folder / (picture + ".tif")}, ChannelType::kColor);
    request.format = format;
    return build(folder / (picture + std::string(format_info(format).name) + ".vts"), request).remarks;
  };
  EXPECT_TRUE(remarks("bright", TexelFormat::kRgb8).empty());
  EXPECT_TRUE(remarks("dark", TexelFormat::kRgb8).empty());
  const auto said = remarks("dark", TexelFormat::kBc1);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("layer 'color': bc1 keeps "), std::string::npos) << said[0];
  EXPECT_NE(said[0].find(" % of the light of level "), std::string::npos) << said[0];
}

TEST(ColorLayer, EveryCodeComesBackAtTheFinestLevelOfAnAlignedSourceInEveryPath) {
  const Codes all = [](std::int64_t x, std::int64_t y, int band) { return static_cast<double>((x + 16 * y + 85 * band) % 256); };
  for (const bool has_alpha : {false, true})
    for (const bool is_grey : {false, true}) {
      const test::TempFolder folder;
      const int bands = (is_grey ? 1 : 3) + (has_alpha ? 1 : 0);
      write_raster(folder / "input.tif", {.width = 64, .height = 64, .bands = bands, .alpha = has_alpha},
                   [&](std::int64_t x, std::int64_t y, int band) {
                     return has_alpha && band == bands - 1 ? 255.0 - static_cast<double>(x) : all(x, y, band);
                   });
      build(folder / "a.vts", request_for({folder / "input.tif"}, ChannelType::kColor));
      const LayerInfo layer = layer_of(folder / "a.vts");
      const Tiles tiles = tiles_of(folder / "a.vts", "color");
      const auto channels = static_cast<int>(format_info(layer.format).channels);
      for (std::int64_t y = 0; y < 64; ++y)
        for (std::int64_t x = 0; x < 64; ++x)
          for (int c = 0; c < 3; ++c) {
            const int code = channels == 4 ? texel_at<std::uint8_t, 4>(tiles, 5, layer.finest, x, y)[static_cast<std::size_t>(c)]
                                           : texel_at<std::uint8_t, 3>(tiles, 5, layer.finest, x, y)[static_cast<std::size_t>(c)];
            ASSERT_EQ(code, all(x, y, is_grey ? 0 : c)) << has_alpha << is_grey;
          }
    }
}

TexelFormat format_without_choice(const LayerRequest& request) {
  const auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  EXPECT_TRUE(plan.has_value()) << (plan ? "" : plan.error().message);
  return plan ? plan->info.format : TexelFormat::kBlob;
}

TEST(ColorLayer, AFormatWithCoverageIsTakenUnlessEveryTexelSurelyHasData) {
  const test::TempFolder folder;
  const auto file = [&](const std::string& name, const RasterSpec& spec) {
    write_raster(folder / name, spec, dark(200));
    return folder / name;
  };
  const auto at = [](double x, double y, double step = 2.0) {
    return geo::GeoTransform{500000.0 + x, step, 0.0, 5400000.0 - y, 0.0, -step};
  };
  const auto west = file("west.tif", {.width = 40, .height = 40});
  const auto east = file("east.tif", {.width = 40, .height = 40, .transform = at(80, 0)});
  const auto beyond = file("beyond.tif", {.width = 40, .height = 40, .transform = at(82, 0)});
  const auto shifted = file("shifted.tif", {.width = 40, .height = 40, .transform = at(0.7, 0.7)});
  const auto fine = file("fine.tif", {.width = 160, .height = 160, .transform = at(0, 0, 0.5)});
  const auto turned = file("turned.tif", {.width = 40, .height = 40, .transform = {500000.0, 1.4, 1.4, 5400000.0, 1.4, -1.4}});
  const auto grey16 = file("grey16.tif", {.width = 40, .height = 40, .bands = 1, .type = SampleType::kUint16});
  const auto nodata = file("nodata.tif", {.width = 40, .height = 40, .nodata = 0.0});
  const auto with_alpha = file("alpha.tif", {.width = 40, .height = 40, .bands = 4, .alpha = true});
  const auto floats = file("floats.tif", {.width = 40, .height = 40, .type = SampleType::kFloat32});
  const auto format = [](const std::vector<std::filesystem::path>& files, const std::function<void(LayerRequest&)>& change = {}) {
    LayerRequest request = request_for(files, ChannelType::kColor);
    if (change) change(request);
    return format_without_choice(request);
  };
  constexpr TexelFormat kOpaque = TexelFormat::kRgb8;
  constexpr TexelFormat kCovered = TexelFormat::kRgba8;
  EXPECT_EQ(format({west}), kOpaque);
  EXPECT_EQ(format({grey16}), kOpaque);
  EXPECT_EQ(format({west, east}), kOpaque);
  EXPECT_EQ(format({west, beyond}), kCovered) << "a column between them has no data";
  EXPECT_EQ(format({west, shifted}), kCovered) << "two corners have none";
  EXPECT_EQ(format({west, fine}), kOpaque) << "what lies on another grid does not uncover what is there";
  EXPECT_EQ(format({west}, [](LayerRequest& r) { r.area = Area{500000.0, 5400000.0 - 90, 500000.0 + 80, 5400000.0}; }), kCovered);
  EXPECT_EQ(format({west}, [](LayerRequest& r) { r.area = Area{500010.0, 5400000.0 - 70, 500000.0 + 60, 5400000.0}; }), kOpaque);
  // 40 samples of 2 m in texels of 3 m are 26 2/3 of them, and the centre of the last is inside.
  EXPECT_EQ(format({west}, [](LayerRequest& r) { r.gsd_m = 3.0; }), kOpaque);
  EXPECT_EQ(format({west}, [](LayerRequest& r) { r.gsd_m = 32.0; }), kCovered) << "the centre of the last lies on the edge";
  EXPECT_EQ(format({turned}), kCovered);
  EXPECT_EQ(format({west}, [](LayerRequest& r) { r.crs = geo::Crs::from_epsg(4326).value(); }), kCovered);
  EXPECT_EQ(format({nodata}), kCovered);
  EXPECT_EQ(format({with_alpha}), kCovered);
  EXPECT_EQ(format({with_alpha, west}), kOpaque) << "an opaque one lies over it";
  EXPECT_EQ(format({floats}, [](LayerRequest& r) { r.range = std::array<double, 2>{0.0, 1.0}; }), kCovered) << "any of them may be NaN";
}

TEST(ColorLayer, UncoveredTexelsAreClearWithoutAChoiceAndSaidOfAnOpaqueFormat) {
  const test::TempFolder folder;
  // Turned by 45 degrees: the corners of the layer are outside.
  write_raster(folder / "turned.tif", {.width = 40, .height = 40, .transform = {500000.0, 1.4, 1.4, 5400000.0, 1.4, -1.4}},
               [](std::int64_t, std::int64_t, int) { return 200.0; });
  LayerRequest request = request_for({folder / "turned.tif"}, ChannelType::kColor);
  const BuildReport clear = build(folder / "clear.vts", request);
  EXPECT_TRUE(clear.remarks.empty());
  const LayerInfo layer = layer_of(folder / "clear.vts");
  const Tiles tiles = tiles_of(folder / "clear.vts", "color");
  std::uint64_t uncovered = 0;
  std::int64_t first_x = -1;
  std::int64_t first_y = -1;
  for (std::int64_t y = 0; y < layer.data.height; ++y)
    for (std::int64_t x = 0; x < layer.data.width; ++x) {
      const bool is_there = tiles.contains({layer.finest, static_cast<std::uint32_t>(x >> 5), static_cast<std::uint32_t>(y >> 5)});
      const int alpha = is_there ? texel_at<std::uint8_t, 4>(tiles, 5, layer.finest, x, y)[3] : 0;
      EXPECT_TRUE(alpha == 0 || alpha == 255);
      if (alpha != 0) continue;
      if (uncovered++ == 0) first_x = x, first_y = y;
    }
  EXPECT_GT(uncovered, 500U);

  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kBc1}) {
    request.format = format;
    const std::string name(format_info(format).name);
    const BuildReport report = build(folder / (name + ".vts"), request, {.block_levels = 1});
    ASSERT_EQ(report.remarks.size(), 1U) << name;
    const std::string& remark = report.remarks.front();
    EXPECT_NE(remark.find("first in " + std::to_string(first_x) + "," + std::to_string(first_y)), std::string::npos) << remark;
    EXPECT_NE(remark.find(name + " cannot say: it shows the neighbours' colour, or black"), std::string::npos) << remark;
    const auto losses = nlohmann::json::parse(layer_of(folder / (name + ".vts")).metadata_json).at("losses");
    ASSERT_EQ(losses.size(), 1U);
    EXPECT_EQ(losses[0].at("texels"), uncovered);
    EXPECT_EQ(losses[0].at("first"), (std::vector<std::int64_t>{first_x, first_y}));
  }
}

TEST(ColorLayer, LevelsOfAStripOneTexelWideReportTheirErrors) {
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kRgba8, TexelFormat::kBc1})
    for (const auto& [width, height] : {std::pair{300, 1}, {1, 300}}) {
      const test::TempFolder folder;
      write_raster(folder / "input.tif", {.width = width, .height = height}, dark(200));
      LayerRequest request = request_for({folder / "input.tif"}, ChannelType::kColor);
      request.format = format;
      build(folder / "a.vts", request);
      const LayerInfo layer = layer_of(folder / "a.vts");
      const auto measures = nlohmann::json::parse(layer.metadata_json).at("quality");
      for (const auto& measure : measures) {
        ASSERT_EQ(measure.at("levels").size(), layer.finest.value + std::size_t{1}) << measure.at("name");
        for (const auto& row : measure.at("levels")) {
          const TexelRect data = layer.data_rect(Level{row.at("level").get<std::uint8_t>()});
          EXPECT_EQ(row.at("measured"), data.width * data.height * (measure.at("name") == "light" ? 3 : 1));
        }
      }
    }
}

}  // namespace
}  // namespace vt::pipeline
