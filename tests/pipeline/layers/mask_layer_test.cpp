// Whole layers of masks: shares that are conserved, and alpha tests that keep their area.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "builder/pipeline/passes/coverage_pass.h"
#include "tests/pipeline/level_values.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// Leaves: blobs of a few texels with soft edges, about a third of the area.
double foliage(std::int64_t x, std::int64_t y, int) {
  double nearest = 9.0;
  for (std::int64_t cy = y / 7 - 1; cy <= y / 7 + 1; ++cy)
    for (std::int64_t cx = x / 7 - 1; cx <= x / 7 + 1; ++cx) {
      const std::uint32_t h = hash_noise(cx, cy, 5);
      const double dx = static_cast<double>(x) - (static_cast<double>(cx * 7) + h % 7);
      const double dy = static_cast<double>(y) - (static_cast<double>(cy * 7) + h / 7 % 7);
      nearest = std::min(nearest, std::sqrt(dx * dx + dy * dy) - static_cast<double>(h / 49 % 3));
    }
  return std::clamp(255.0 * (1.1 - nearest * 0.25) + static_cast<double>(hash_noise(x, y, 6) % 32), 0.0, 255.0);
}

LayerRequest mask_request(const std::filesystem::path& input, TexelFormat format, const channels::Options& options) {
  LayerRequest request = request_for({input}, ChannelType::kMask);
  request.format = format;
  request.options = options;
  return request;
}

double share_above(const LevelValues& values, double reference) {
  std::int64_t above = 0;
  for (std::int64_t y = 0; y < values.height(); ++y)
    for (std::int64_t x = 0; x < values.width(); ++x) above += values.at(x, y) > reference ? 1 : 0;
  return static_cast<double>(above) / static_cast<double>(values.width() * values.height());
}

TEST(MaskLayer, KeepsTheCoveredArea) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 512, .height = 512, .bands = 1}, foliage);
  for (const TexelFormat format : {TexelFormat::kR8, TexelFormat::kR16, TexelFormat::kBc4}) {
    const auto path = folder / (std::string(format_info(format).name) + ".vts");
    build(path, mask_request(folder / "input.tif", format, {}));
    auto reader = store::StoreReader::open(path);
    ASSERT_TRUE(reader.has_value());
    const LayerInfo& layer = *reader->find_layer("mask");
    double finest = 0.0;
    for (int level = layer.finest.value; level >= 0; --level) {
      const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(level)});
      double sum = 0.0;
      for (std::int64_t y = 0; y < values.height(); ++y)
        for (std::int64_t x = 0; x < values.width(); ++x) sum += values.at(x, y);
      const double mean = sum / static_cast<double>(values.width() * values.height());
      if (level == layer.finest.value) finest = mean;
      // Rounding of n bytes leaves 0.29 / 255 / sqrt(n) rms, here 1024 and more: 0.00004; three of them.
      // Blocks add their own error.
      EXPECT_NEAR(mean, finest, format == TexelFormat::kBc4 ? 0.002 : 0.00012) << format_info(format).name << " level " << level;
    }
  }
}

TEST(MaskLayer, AlphaTestsKeepTheirAreaOnlyWhenAskedTo) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 509, .height = 387, .bands = 1}, foliage);
  for (const double reference : {0.3, 0.5, 0.75}) {
    const test::TempFolder stores;
    build(stores / "plain.vts", mask_request(folder / "input.tif", TexelFormat::kR8, {}));
    build(stores / "kept.vts", mask_request(folder / "input.tif", TexelFormat::kR8, {{"alpha-coverage", std::to_string(reference)}}));
    auto plain = store::StoreReader::open(stores / "plain.vts");
    auto kept = store::StoreReader::open(stores / "kept.vts");
    ASSERT_TRUE(plain.has_value() && kept.has_value());
    const LayerInfo& layer = *kept->find_layer("mask");
    const auto metadata = nlohmann::json::parse(layer.metadata_json);
    EXPECT_EQ(metadata["alpha_coverage"]["above"], reference);
    const double wanted = share_above(LevelValues(*kept, layer, layer.finest), reference);
    EXPECT_EQ(metadata["alpha_coverage"]["share"], wanted);
    double worst_plain = 0.0;
    for (int level = layer.finest.value - 1; level >= 0; --level) {
      const Level l{static_cast<std::uint8_t>(level)};
      const LevelValues values(*kept, layer, l);
      // Texels of equal means go together: half of them may be missed, and half a texel where there is but
      // one.
      const LevelValues means(*kept, *kept->find_layer("mask/mean"), l);
      std::map<double, int> equals;
      int most = 1;
      for (std::int64_t y = 0; y < means.height(); ++y)
        for (std::int64_t x = 0; x < means.width(); ++x)
          if (means.at(x, y) > 0.05 && means.at(x, y) < 0.95) most = std::max(most, ++equals[means.at(x, y)]);
      const double texel = 1.0 / static_cast<double>(values.width() * values.height());
      const double share = share_above(values, reference);
      EXPECT_LE(std::abs(share - wanted), 0.5 * most * texel) << reference << " level " << level << ", up to " << most << " equal means";
      EXPECT_LE(std::abs(share - wanted), std::max(0.002, 0.5 * texel)) << reference << " level " << level;
      EXPECT_EQ(metadata["alpha_coverage"]["levels"][static_cast<std::size_t>(layer.finest.value - 1 - level)]["share"], share);
      worst_plain = std::max(worst_plain, std::abs(share_above(LevelValues(*plain, *plain->find_layer("mask"), l), reference) - wanted));
    }
    EXPECT_GT(worst_plain, 0.05) << "plain means lose the area";
  }
}

TEST(MaskLayer, BlocksKeepTheAreaOfAlphaTestsUpToTheirOwnError) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 512, .height = 512, .bands = 1}, foliage);
  build(folder / "a.vts", mask_request(folder / "input.tif", TexelFormat::kBc4, {{"alpha-coverage", "0.5"}}));
  auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LayerInfo& layer = *reader->find_layer("mask");
  const double wanted = share_above(LevelValues(*reader, layer, layer.finest), 0.5);
  const auto coverage = nlohmann::json::parse(layer.metadata_json).at("alpha_coverage");
  EXPECT_EQ(coverage.at("share"), wanted);
  for (int level = 0; level < layer.finest.value; ++level) {
    const double share = share_above(LevelValues(*reader, layer, Level{static_cast<std::uint8_t>(level)}), 0.5);
    EXPECT_NEAR(share, wanted, 0.02) << level;
    EXPECT_EQ(coverage.at("levels").at(static_cast<std::size_t>(layer.finest.value - 1 - level)).at("share"), share)
        << "what is stored, not what went into the blocks";
  }
}

TEST(MaskLayer, AConstantMaskHasNothingToScale) {
  for (const double value : {0.0, 100.0, 127.0, 128.0, 255.0}) {
    const test::TempFolder folder;
    write_raster(folder / "input.tif", {.width = 100, .height = 70, .bands = 1}, [&](std::int64_t, std::int64_t, int) { return value; });
    build(folder / "a.vts", mask_request(folder / "input.tif", TexelFormat::kR8, {{"alpha-coverage", "0.5"}}));
    auto reader = store::StoreReader::open(folder / "a.vts");
    ASSERT_TRUE(reader.has_value());
    const LayerInfo& layer = *reader->find_layer("mask");
    for (int level = 0; level <= layer.finest.value; ++level) {
      const LevelValues values(*reader, layer, Level{static_cast<std::uint8_t>(level)});
      for (std::int64_t y = 0; y < values.height(); ++y)
        for (std::int64_t x = 0; x < values.width(); ++x) ASSERT_EQ(std::round(values.at(x, y) * 255.0), value);
    }
  }
}

TEST(MaskLayer, AnUpdateGivesTheTilesOfANewBuild) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 300, .height = 200, .bands = 1};
  const channels::Options options{{"alpha-coverage", "0.5"}};
  write_raster(folder / "input.tif", spec, foliage);
  build(folder / "updated.vts", mask_request(folder / "input.tif", TexelFormat::kR8, options), {.block_levels = 1});
  write_raster(folder / "input.tif", spec,
               [](std::int64_t x, std::int64_t y, int band) { return x < 40 && y < 50 ? 255.0 : foliage(x, y, band); });
  build(folder / "updated.vts", mask_request(folder / "input.tif", TexelFormat::kR8, options), {.update = true});
  build(folder / "new.vts", mask_request(folder / "input.tif", TexelFormat::kR8, options));
  for (const char* name : {"mask", "mask/mean"})
    EXPECT_TRUE(tiles_of(folder / "updated.vts", name) == tiles_of(folder / "new.vts", name)) << name;
}

TEST(MaskLayer, TheCoverageBandOfAPictureIsItsMask) {
  const test::TempFolder folder;
  write_raster(folder / "input.tif", {.width = 64, .height = 64, .bands = 4, .alpha = true},
               [](std::int64_t x, std::int64_t, int band) { return band == 3 ? (x < 32 ? 255.0 : 51.0) : 99.0; });
  build(folder / "a.vts", mask_request(folder / "input.tif", TexelFormat::kR8, {}));
  auto reader = store::StoreReader::open(folder / "a.vts");
  ASSERT_TRUE(reader.has_value());
  const LevelValues values(*reader, *reader->find_layer("mask"), Level{0});
  EXPECT_EQ(values.at(3, 3), 1.0);
  EXPECT_EQ(values.at(30, 3), 0.2);
}

// By brute force over every threshold.
TEST(CoverageScale, ReachesTheNearestCountThatAnyScaleCan) {
  std::mt19937 random(8);
  for (int round = 0; round < 60; ++round) {
    std::vector<std::uint64_t> histogram(65536, 0);
    const int bins = 1 + static_cast<int>(random() % 40);
    std::uint64_t total = 0;
    for (int i = 0; i < bins; ++i) {
      const std::uint64_t count = random() % 100;
      histogram[random() % 65536] += count;
      total += count;
    }
    const double wanted = static_cast<double>(random() % 1001) / 1000.0 * static_cast<double>(total);
    const double reference = 0.01 + static_cast<double>(random() % 99) / 100.0 * 0.98;
    const int full = round % 2 == 0 ? 255 : 65535;
    const CoverageScale chosen = choose_coverage_scale(histogram, wanted, reference, full);

    const auto above_with = [&](double scale) {
      std::uint64_t above = 0;
      for (std::size_t mean = 0; mean < histogram.size(); ++mean) {
        if (histogram[mean] == 0) continue;
        const double code = std::floor(std::min(1.0, scale * static_cast<double>(mean) / 65535.0) * full + 0.5);
        if (code / full > reference) above += histogram[mean];
      }
      return above;
    };
    EXPECT_EQ(above_with(chosen.scale), chosen.reached_texels);
    double best = std::abs(static_cast<double>(above_with(1.0)) - wanted);
    std::uint64_t above = 0;
    for (std::size_t mean = 65535; mean >= 1; --mean) {
      above += histogram[mean];
      best = std::min(best, std::abs(static_cast<double>(above) - wanted));
    }
    EXPECT_EQ(std::abs(static_cast<double>(chosen.reached_texels) - wanted), best);
  }
}

}  // namespace
}  // namespace vt::pipeline
