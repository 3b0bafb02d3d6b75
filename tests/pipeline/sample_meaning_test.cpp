// From what a file says of its samples to what a layer holds: coverage, full scales, no-data values, scales,
// units and roles, by building small layers from files that are put together tag by tag.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "builder/channels/all_channels.h"
#include "store/store_reader.h"
#include "tests/pipeline/level_values.h"
#include "tests/pipeline/small_builds.h"
#include "tests/support/raw_tiff.h"

namespace vt::pipeline {
namespace {

using test::pixels_of;
using test::RawTiff;

constexpr std::uint16_t kExtraSamples = 338;
constexpr std::uint16_t kMetadata = 42112;
constexpr std::uint16_t kNodata = 42113;
constexpr std::uint32_t kSide = 8;
constexpr std::size_t kCount = kSide * kSide;

std::string noted(const std::string& items) { return "<GDALMetadata>" + items + "</GDALMetadata>"; }
std::string item(int band, const std::string& role, const std::string& text) {
  return "<Item sample=\"" + std::to_string(band) + "\" role=\"" + role + "\">" + text + "</Item>";
}

class SampleMeaning : public testing::Test {
 protected:
  // Builds `tiff` into a new store; what of the finest level's first part can be looked at.
  LevelValues build_from(const RawTiff& tiff, LayerRequest request) {
    const auto path = folder_ / ("in" + std::to_string(count_) + ".tif");
    tiff.write(path);
    return build_path(path, std::move(request));
  }
  LevelValues build_path(const std::filesystem::path& path, LayerRequest request) {
    request.sources[0].path = path;
    store_ = folder_ / ("s" + std::to_string(count_++) + ".vts");
    build(store_, request);
    auto reader = store::StoreReader::open(store_);
    EXPECT_TRUE(reader.has_value());
    layer_ = *reader->find_layer(request.name);
    return {*reader, layer_, layer_.finest};
  }
  Result<LayerPlan> plan_from(const RawTiff& tiff, LayerRequest request) {
    const auto path = folder_ / ("in" + std::to_string(count_++) + ".tif");
    tiff.write(path);
    request.sources[0].path = path;
    return plan_layer(request, std::nullopt, std::size_t{8} << 20);
  }
  std::string refusal(const RawTiff& tiff, const LayerRequest& request) {
    const auto plan = plan_from(tiff, request);
    EXPECT_FALSE(plan.has_value());
    return plan ? "" : plan.error().message;
  }
  std::string warnings(const RawTiff& tiff, const LayerRequest& request) {
    const auto plan = plan_from(tiff, request);
    EXPECT_TRUE(plan.has_value()) << (plan ? "" : plan.error().message);
    std::string all;
    for (const std::string& warning : plan ? plan->warnings : std::vector<std::string>{}) all += warning + "\n";
    return all;
  }
  static LayerRequest of(ChannelType channel, channels::Options options = {}) {
    LayerRequest request = request_for({"to be named"}, channel);
    request.options = std::move(options);
    return request;
  }

  test::TempFolder folder_;
  std::filesystem::path store_;
  LayerInfo layer_;
  int count_ = 0;
};

// A page of kSide x kSide samples of `bands` numbers each.
template <class T>
RawTiff::Page page_of(const std::vector<T>& samples, std::uint16_t bands = 1, std::uint16_t photometric = 1) {
  const std::uint16_t format = std::is_floating_point_v<T> ? 3 : std::is_signed_v<T> ? 2 : 1;
  return {.width = kSide,
          .height = kSide,
          .bits = 8 * sizeof(T),
          .samples = bands,
          .photometric = photometric,
          .sample_format = format,
          .pixels = pixels_of(samples)};
}

// A mask directory, all rows alike.
void add_mask(RawTiff& tiff, char row) {
  tiff.page({.width = kSide, .height = kSide, .bits = 1, .photometric = 4, .pixels = std::string(kSide, row)}).longs(254, {4});
}

TEST_F(SampleMeaning, AMaskIsAllOrNothingWhateverTheSamplesType) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<std::uint16_t>(3 * kCount, 3000), 3, 2)).utm33();
  add_mask(tiff, '\xF0');
  LayerRequest request = of(ChannelType::kColor);
  request.range = {{0.0, 3000.0}};
  const LevelValues texels = build_from(tiff, request);
  EXPECT_EQ(layer_.format, TexelFormat::kRgba8);
  for (std::int64_t y = 0; y < kSide; ++y)
    for (std::int64_t x = 0; x < kSide; ++x) {
      EXPECT_EQ(texels.at(x, y, 3), x < 4 ? 255.0 : 0.0) << x << ", " << y;
      if (x < 4) {
        EXPECT_EQ(texels.at(x, y, 0), 255.0);
      }
    }
}

TEST_F(SampleMeaning, AlphaOfElevenBitsIsFullAt2047) {
  // Two samples of 11 bits in each of 8 x 8 texels: 0x7FF, then 0x7FF or 0x400, packed most significant bit
  // first.
  std::string pixels;
  for (std::uint32_t row = 0; row < kSide; ++row) {
    std::string bits;
    for (std::uint32_t x = 0; x < kSide; ++x) bits += std::string(11, '1') + (x < 4 ? std::string(11, '1') : "1" + std::string(10, '0'));
    for (std::size_t at = 0; at < bits.size(); at += 8) pixels += static_cast<char>(std::stoi(bits.substr(at, 8), nullptr, 2));
  }
  RawTiff tiff;
  tiff.page({.width = kSide, .height = kSide, .bits = 11, .samples = 2, .pixels = pixels}).utm33().shorts(kExtraSamples, {2});
  const LevelValues texels = build_from(tiff, of(ChannelType::kColor));
  EXPECT_EQ(texels.at(0, 0, 0), 255.0);
  EXPECT_EQ(texels.at(0, 0, 3), 255.0);
  EXPECT_EQ(texels.at(7, 7, 3), std::round(255.0 * 1024.0 / 2047.0));
}

// Every channel: what a mask, a file beside or an alpha band leaves out is no data, and is in no mean.
TEST_F(SampleMeaning, CoverageOfEveryKindReachesEveryChannel) {
  struct Kind {
    ChannelType channel;
    std::uint16_t bands;
    channels::Options options;
    double covered;    // all bands of covered samples
    double uncovered;  // far away, so that a mean would show it
  };
  const std::vector<Kind> kinds = {
      {ChannelType::kElevation, 1, {}, 250.0, 9000.0}, {ChannelType::kSensor, 1, {}, 3.0, 700.0},
      {ChannelType::kHorizon, 2, {}, 0.25, 1.5},       {ChannelType::kMaterial, 1, {}, 5.0, 6.0},
      {ChannelType::kNormal, 2, {}, 0.5, -0.75},       {ChannelType::kIllumination, 1, {}, 2.0, 500.0},
      {ChannelType::kMask, 1, {}, 0.5, 1.0},
  };
  int checked = 0;
  for (const Kind& kind : kinds)
    for (const std::string how : {"mask inside", "mask beside", "alpha band", "band that is named"}) {
      SCOPED_TRACE(std::string(channels::kind_of(kind.channel).name) + ", " + how);
      const bool in_bands = how == "alpha band" || how == "band that is named";
      std::vector<float> samples;
      for (std::size_t i = 0; i < kCount; ++i) {
        const bool is_covered = i % kSide < 5;
        for (int b = 0; b < kind.bands; ++b) samples.push_back(static_cast<float>(is_covered ? kind.covered : kind.uncovered));
        if (in_bands) samples.push_back(is_covered ? 1.0F : 0.0F);
      }
      const auto bands = static_cast<std::uint16_t>(kind.bands + (in_bands ? 1 : 0));
      RawTiff tiff;
      tiff.page(page_of(samples, bands)).utm33();
      if (bands > 1) {
        std::vector<std::uint16_t> extras(bands - 1U, 0);
        if (how == "alpha band") extras.back() = 2;
        tiff.shorts(kExtraSamples, extras);
      }
      LayerRequest request = of(kind.channel, kind.options);
      request.tile_texels = 4;
      if (how == "mask inside") add_mask(tiff, '\xF8');
      if (how == "band that is named") {
        request.sources[0].coverage = {.kind = CoverageChoice::Kind::kBand, .band = bands};
        if (kind.channel == ChannelType::kHorizon || kind.channel == ChannelType::kNormal) request.sources[0].bands = {1, 2};
      }
      const auto path = folder_ / ("c" + std::to_string(checked) + ".tif");
      tiff.write(path);
      if (how == "mask beside") {
        std::string mask;
        for (std::size_t i = 0; i < kCount; ++i) mask += i % kSide < 5 ? '\xFF' : '\0';
        RawTiff beside;
        beside.page({.width = kSide, .height = kSide, .pixels = mask}).write(folder_ / ("c" + std::to_string(checked) + ".tif.msk"));
      }
      const LevelValues finest = build_path(path, request);
      // The mean of the coarser texel that lies half over covered and half over uncovered samples is that of
      // the covered ones.
      auto reader = store::StoreReader::open(store_);
      ASSERT_TRUE(reader.has_value());
      const LevelValues coarser(*reader, layer_, Level{0});
      ASSERT_EQ(coarser.width(), 4);
      const double wanted = finest.at(1, 1);
      EXPECT_FALSE(std::isnan(wanted));
      EXPECT_EQ(coarser.at(2, 0), wanted);
      EXPECT_EQ(coarser.at(0, 0), wanted);
      if (kind.channel == ChannelType::kElevation || kind.channel == ChannelType::kSensor) {
        EXPECT_EQ(wanted, kind.covered);
        EXPECT_TRUE(finest.is_void(6, 1));
      }
      if (kind.channel == ChannelType::kMaterial) {
        EXPECT_EQ(wanted, kind.covered);
        EXPECT_EQ(finest.at(6, 1), 65535.0) << "the class of no data of r16, which floats become";
      }
      ++checked;
    }
  EXPECT_EQ(checked, 28);
}

TEST_F(SampleMeaning, CoverageCanBeLeftAlone) {
  std::vector<std::uint8_t> samples;
  for (std::size_t i = 0; i < kCount; ++i) samples.insert(samples.end(), {100, 110, 120, 7});
  RawTiff tiff;
  tiff.page(page_of(samples, 4, 2)).utm33().shorts(kExtraSamples, {2});
  EXPECT_EQ(build_from(tiff, of(ChannelType::kColor)).at(3, 3, 3), 7.0);
  EXPECT_EQ(layer_.format, TexelFormat::kRgba8);
  // Exactly the bands that are named.
  LayerRequest named = of(ChannelType::kColor);
  named.sources[0].bands = {3, 2, 1};
  const LevelValues opaque = build_from(tiff, named);
  EXPECT_EQ(layer_.format, TexelFormat::kRgb8);
  EXPECT_EQ(opaque.at(3, 3, 0), 120.0);
  EXPECT_NE(warnings(tiff, named).find("band 4"), std::string::npos) << "what is left out is mentioned";
  named.sources[0].bands = {1, 2, 3, 4};
  EXPECT_EQ(build_from(tiff, named).at(3, 3, 3), 7.0) << "the alpha band is named";
  LayerRequest none = of(ChannelType::kColor);
  none.sources[0].coverage = {.kind = CoverageChoice::Kind::kNone};
  build_from(tiff, none);
  EXPECT_EQ(layer_.format, TexelFormat::kRgb8);
  EXPECT_EQ(warnings(tiff, none).find("band 4"), std::string::npos) << "somebody who says so need not be told";
  LayerRequest beyond = of(ChannelType::kColor);
  beyond.sources[0].coverage = {.kind = CoverageChoice::Kind::kBand, .band = 5};
  EXPECT_NE(refusal(tiff, beyond).find("band 5"), std::string::npos);
}

TEST_F(SampleMeaning, InfraredIsNoCoverageAndColoursAreFoundByTheirRoles) {
  std::vector<std::uint8_t> samples;
  for (std::size_t i = 0; i < kCount; ++i) samples.insert(samples.end(), {30, 20, 10, 99});
  RawTiff tiff;
  tiff.page(page_of(samples, 4, 2))
      .utm33()
      .shorts(kExtraSamples, {2})
      .text(kMetadata, noted(item(0, "colorinterp", "Blue") + item(1, "colorinterp", "Green") + item(2, "colorinterp", "Red") +
                             item(3, "colorinterp", "Undefined")));
  const LevelValues texels = build_from(tiff, of(ChannelType::kColor));
  EXPECT_EQ(layer_.format, TexelFormat::kRgb8);
  EXPECT_EQ(texels.at(2, 2, 0), 10.0);
  EXPECT_EQ(texels.at(2, 2, 1), 20.0);
  EXPECT_EQ(texels.at(2, 2, 2), 30.0);
}

// Nobody has said which of many bands are the colours: the first are taken, and that is said.
TEST_F(SampleMeaning, BandsThatAreChosenForTheUserAreNamed) {
  RawTiff many;
  many.page(page_of(std::vector<std::uint8_t>(6 * kCount, 50), 6)).utm33().shorts(kExtraSamples, {0, 0, 0, 0, 0});
  EXPECT_NE(warnings(many, of(ChannelType::kColor)).find("bands 1, 2 and 3 of 6 are taken; `bands` names others"), std::string::npos);
  const auto path = folder_ / "many.tif";
  many.write(path);
  LayerRequest named = of(ChannelType::kColor);
  named.sources[0].path = path;
  named.sources[0].bands = {4, 3, 2};
  const auto plan = plan_layer(named, std::nullopt, std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  EXPECT_TRUE(plan->warnings.empty());
  RawTiff three;
  three.page(page_of(std::vector<std::uint8_t>(3 * kCount, 50), 3, 2)).utm33();
  EXPECT_EQ(warnings(three, of(ChannelType::kColor)), "");
}

TEST_F(SampleMeaning, NarrowCodesAreWhiteAtTheirLargest) {
  RawTiff bits;
  bits.page({.width = kSide, .height = kSide, .bits = 1, .pixels = std::string(kSide, '\x0F')}).utm33();
  RawTiff nibbles;
  nibbles.page({.width = kSide, .height = kSide, .bits = 4, .pixels = std::string(kSide * 4, '\x5F')}).utm33();
  RawTiff white;
  white.page({.width = kSide, .height = kSide, .bits = 1, .photometric = 0, .pixels = std::string(kSide, '\x0F')}).utm33();
  const LevelValues of_bits = build_from(bits, of(ChannelType::kColor));
  EXPECT_EQ(of_bits.at(0, 0), 0.0);
  EXPECT_EQ(of_bits.at(5, 0), 255.0);
  EXPECT_EQ(build_from(white, of(ChannelType::kColor)).at(5, 0), 0.0) << "0 is white";
  const LevelValues of_nibbles = build_from(nibbles, of(ChannelType::kColor));
  EXPECT_EQ(of_nibbles.at(0, 0), 85.0);
  EXPECT_EQ(of_nibbles.at(1, 0), 255.0);
  EXPECT_EQ(build_from(bits, of(ChannelType::kMask)).at(5, 0), 1.0);
  EXPECT_NEAR(build_from(nibbles, of(ChannelType::kMask)).at(0, 0), 1.0 / 3.0, 1e-6);
}

TEST_F(SampleMeaning, HeightsOfAMinIsWhiteFileStayTheirNumbers) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<std::uint16_t>(kCount, 1000), 1, 0)).utm33();
  EXPECT_EQ(build_from(tiff, of(ChannelType::kElevation)).at(0, 0), 1000.0);
}

TEST_F(SampleMeaning, PalettesWithAlphaAreColours) {
  std::vector<std::uint16_t> colors(3 * 256, 0);
  colors[7] = 65535;
  std::vector<std::uint8_t> samples;
  for (std::size_t i = 0; i < kCount; ++i) samples.insert(samples.end(), {7, static_cast<std::uint8_t>(i % kSide < 4 ? 255 : 0)});
  RawTiff tiff;
  tiff.page(page_of(samples, 2, 3)).utm33().shorts(320, colors).shorts(kExtraSamples, {2});
  const LevelValues texels = build_from(tiff, of(ChannelType::kColor));
  for (const std::size_t c : {0, 1, 2, 3}) EXPECT_EQ(texels.at(2, 5, c), c == 0 || c == 3 ? 255.0 : 0.0);
  EXPECT_EQ(texels.at(5, 5, 3), 0.0);
  // As classes it is what the indices are.
  const LevelValues classes = build_from(tiff, of(ChannelType::kMaterial));
  EXPECT_EQ(classes.at(2, 5), 7.0);
  EXPECT_EQ(classes.at(5, 5), 255.0);
}

TEST_F(SampleMeaning, MetresAreMetresInTheStore) {
  RawTiff centimetres;
  centimetres.page(page_of(std::vector<std::int32_t>(kCount, 10740)))
      .utm33()
      .text(kMetadata, noted(item(0, "scale", "0.01") + item(0, "offset", "0")))
      .text(kNodata, "-99999");
  EXPECT_NEAR(build_from(centimetres, of(ChannelType::kElevation)).at(2, 2), 107.4, 1e-5);
  EXPECT_TRUE(std::isnan(layer_.source_nodata)) << "-99999 is a sample, no height";
  EXPECT_NE(warnings(centimetres, of(ChannelType::kElevation)).find("0.01 * sample"), std::string::npos);

  RawTiff feet;
  feet.page(page_of(std::vector<float>(kCount, 320.0F))).utm33().text(kMetadata, noted(item(0, "unittype", "US survey foot")));
  EXPECT_NEAR(build_from(feet, of(ChannelType::kElevation)).at(2, 2), 320.0 * 1200.0 / 3937.0, 1e-5);
  EXPECT_EQ(build_from(feet, of(ChannelType::kElevation, {{"input-unit", "m"}})).at(2, 2), 320.0) << "who gives a unit knows better";

  RawTiff both;
  both.page(page_of(std::vector<std::int16_t>(kCount, -50)))
      .utm33()
      .text(kMetadata, noted(item(0, "scale", "0.1") + item(0, "offset", "100") + item(0, "unittype", "ft")));
  EXPECT_NEAR(build_from(both, of(ChannelType::kElevation)).at(2, 2), 95.0 * 0.3048, 1e-5);
  LayerRequest coded = of(ChannelType::kElevation);
  coded.format = TexelFormat::kR16;
  EXPECT_NEAR(build_from(both, coded).at(2, 2), 95.0 * 0.3048, 0.1) << "r16 spans what the scaled type can say";
  EXPECT_NEAR(build_from(both, of(ChannelType::kElevation, {{"input-scale", "2"}, {"input-offset", "1"}, {"input-unit", "cm"}})).at(2, 2),
              -0.99, 1e-6);

  RawTiff strange;
  strange.page(page_of(std::vector<float>(kCount, 320.0F))).utm33().text(kMetadata, noted(item(0, "unittype", "degC")));
  const std::string refused = refusal(strange, of(ChannelType::kElevation));
  EXPECT_NE(refused.find("degC"), std::string::npos) << refused;
  EXPECT_NE(refused.find("input-unit"), std::string::npos) << refused;
  EXPECT_NE(refusal(feet, of(ChannelType::kElevation, {{"input-unit", "furlong"}})).find("furlong"), std::string::npos);
  EXPECT_NE(refusal(feet, of(ChannelType::kElevation, {{"input-scale", "0"}})).find("option input-scale"), std::string::npos);
}

TEST_F(SampleMeaning, DepthsAreRefusedUntilSomebodySaysWhatTheyAre) {
  RawTiff depths;
  depths.page(page_of(std::vector<float>(kCount, 12.0F))).utm33().shorts(34735, {1, 1, 0,    4, 1024, 0,     1,    1, 1025, 0,
                                                                                 1, 1, 3072, 0, 1,    32633, 4096, 0, 1,    5715});
  EXPECT_NE(refusal(depths, of(ChannelType::kElevation)).find("input-scale -1"), std::string::npos);
  EXPECT_EQ(build_from(depths, of(ChannelType::kElevation, {{"input-scale", "-1"}})).at(0, 0), -12.0);
}

TEST_F(SampleMeaning, SensorsTakeScaleAndUnit) {
  RawTiff celsius;
  celsius.page(page_of(std::vector<std::int16_t>(kCount, 215)))
      .utm33()
      .text(kMetadata, noted(item(0, "scale", "0.1") + item(0, "unittype", "degC")));
  const channels::Options thermal{{"quantity", "temperature"}, {"band", "8,12"}, {"store", "temperature"}};
  EXPECT_NEAR(build_from(celsius, of(ChannelType::kSensor, thermal)).at(1, 1), 273.15 + 21.5, 1e-3);
  channels::Options kelvin = thermal;
  kelvin["input-unit"] = "K";
  kelvin["input-offset"] = "200";
  EXPECT_NEAR(build_from(celsius, of(ChannelType::kSensor, kelvin)).at(1, 1), 221.5, 1e-3);
  EXPECT_NE(refusal(celsius, of(ChannelType::kSensor, {{"quantity", "reflectance"}})).find("degC"), std::string::npos);
  RawTiff percent;
  percent.page(page_of(std::vector<std::uint8_t>(kCount, 40))).utm33().text(kMetadata, noted(item(0, "unittype", "%")));
  EXPECT_NEAR(build_from(percent, of(ChannelType::kSensor, {{"quantity", "reflectance"}})).at(1, 1), 0.4, 1e-7);
  RawTiff radiance;
  radiance.page(page_of(std::vector<float>(kCount, 9.0F))).utm33().text(kMetadata, noted(item(0, "unittype", "W/(m2 sr um)")));
  build_from(radiance, of(ChannelType::kSensor));
  auto reader = store::StoreReader::open(store_);
  EXPECT_NE(reader->find_layer("sensor")->metadata_json.find("W/(m2 sr um)"), std::string::npos) << "the layer is in the file's unit";
}

// A raster with a vertical CRS says what its numbers are in case they are heights. Radiance on such
// coordinates is no height.
TEST_F(SampleMeaning, WhatIsSaidOfHeightsIsSaidOfNothingElse) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<float>(kCount, 300.0F))).utm33().doubles(33550, {10.0, 10.0, 2.0}).shorts(34735, {1,    1, 0, 4,
                                                                                                                  1024, 0, 1, 1,
                                                                                                                  1025, 0, 1, 1,
                                                                                                                  3072, 0, 1, 32633,
                                                                                                                  4096, 0, 1, 6360});
  const double foot = 1200.0 / 3937.0;
  EXPECT_NEAR(build_from(tiff, of(ChannelType::kElevation)).at(1, 1), 600.0 * foot, 1e-4);
  EXPECT_EQ(build_from(tiff, of(ChannelType::kSensor)).at(1, 1), 300.0);
  EXPECT_EQ(store::StoreReader::open(store_)->find_layer("sensor")->metadata_json.find("0.3048"), std::string::npos);
  const channels::Options kelvin{{"quantity", "temperature"}, {"band", "8,12"}, {"store", "temperature"}};
  EXPECT_NEAR(build_from(tiff, of(ChannelType::kSensor, kelvin)).at(1, 1), 300.0, 1e-3);
  LayerRequest color = of(ChannelType::kColor);
  color.range = {{0.0, 1000.0}};
  EXPECT_EQ(warnings(tiff, color).find("scale"), std::string::npos);
  // What the band says of itself goes before it.
  tiff.text(kMetadata, noted(item(0, "scale", "3") + item(0, "unittype", "m")));
  EXPECT_NEAR(build_from(tiff, of(ChannelType::kElevation)).at(1, 1), 900.0, 1e-4);
}

TEST_F(SampleMeaning, AUnitOfHeightsThatIsNotKnownIsRefused) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<float>(kCount, 100.0F))).utm33().shorts(34735, {1, 1, 0,    4, 1024, 0,     1,    1, 1025, 0,
                                                                                1, 1, 3072, 0, 1,    32633, 4099, 0, 1,    9095});
  const std::string refused = refusal(tiff, of(ChannelType::kElevation));
  EXPECT_NE(refused.find("unit 9095 (GeoKey 4099)"), std::string::npos) << refused;
  EXPECT_NE(refused.find("input-unit"), std::string::npos) << refused;
  EXPECT_NEAR(build_from(tiff, of(ChannelType::kElevation, {{"input-unit", "0.3048007491 m"}})).at(0, 0), 30.48007491, 1e-5);
}

// Codes with an offset are numbers that floats do not hold, whatever their type.
TEST_F(SampleMeaning, ALargeOffsetLosesNothing) {
  std::vector<std::uint16_t> codes;
  for (std::size_t i = 0; i < kCount; ++i) codes.push_back(static_cast<std::uint16_t>(i));
  RawTiff tiff;
  tiff.page(page_of(codes)).utm33().text(kMetadata, noted(item(0, "scale", "0.001") + item(0, "offset", "1000000")));
  LayerRequest request = of(ChannelType::kElevation, {{"quantum", "0.001"}});
  request.format = TexelFormat::kR16;
  request.range = {{1000000.0, 1000005.0}};
  const LevelValues texels = build_from(tiff, request);
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(kCount); ++i) {
    EXPECT_NEAR(texels.at(i % kSide, i / kSide), 1e6 + 0.001 * static_cast<double>(i), 0.0005) << i;
  }
}

// A mask for each band is one for all where all are taken; otherwise it would hide data that only another
// band has not.
TEST_F(SampleMeaning, MasksOfBandsThatAreNotTakenAreNotUsed) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<std::uint8_t>(3 * kCount, 90), 3, 2)).utm33();
  std::string mask;
  for (std::size_t i = 0; i < kCount; ++i) mask += i < 8 ? std::string("\xFF\xFF\x00", 3) : std::string("\xFF\xFF\xFF", 3);
  tiff.page({.width = kSide, .height = kSide, .samples = 3, .photometric = 4, .pixels = mask}).longs(254, {4});
  EXPECT_EQ(build_from(tiff, of(ChannelType::kColor)).at(0, 0, 3), 0.0);
  const auto path = folder_ / "masks.tif";
  tiff.write(path);
  LayerRequest one = of(ChannelType::kElevation);
  one.sources[0].path = path;
  one.sources[0].bands = {1, 4};
  const auto plan = plan_layer(one, std::nullopt, std::size_t{8} << 20);
  ASSERT_FALSE(plan.has_value());
  EXPECT_NE(plan.error().message.find("a mask for each of 3 bands, of which the layer takes 1"), std::string::npos) << plan.error().message;
}

TEST_F(SampleMeaning, FilesOfDifferentUnitsAreNoOneLayer) {
  RawTiff watts;
  watts.page(page_of(std::vector<float>(kCount, 5.0F))).utm33().text(kMetadata, noted(item(0, "unittype", "W/(m2 sr um)")));
  RawTiff milliwatts;
  milliwatts.page(page_of(std::vector<float>(kCount, 5000.0F)))
      .utm33()
      .doubles(33922, {0.0, 0.0, 0.0, 500080.0, 5000000.0, 0.0})
      .text(kMetadata, noted(item(0, "unittype", "mW/(m2 sr um)")));
  watts.write(folder_ / "w.tif");
  milliwatts.write(folder_ / "mw.tif");
  const auto plan =
      plan_layer(request_for({folder_ / "w.tif", folder_ / "mw.tif"}, ChannelType::kSensor), std::nullopt, std::size_t{8} << 20);
  ASSERT_FALSE(plan.has_value());
  EXPECT_NE(plan.error().message.find("another unit"), std::string::npos) << plan.error().message;
}

TEST_F(SampleMeaning, HorizonsThatLookLikeDegreesAreRefused) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<float>(2 * kCount, 10.0F), 2)).utm33();
  const channels::Options east_and_west{{"azimuths", "90,270"}};
  const std::string refused = refusal(tiff, of(ChannelType::kHorizon, east_and_west));
  EXPECT_NE(refused.find("angles up to 10, more than any horizon has in radians; say `angles` deg"), std::string::npos) << refused;
  build_from(tiff, of(ChannelType::kHorizon, {{"azimuths", "90,270"}, {"angles", "deg"}}));
  RawTiff radians;
  radians.page(page_of(std::vector<float>(2 * kCount, 1.5F), 2)).utm33();
  build_from(radians, of(ChannelType::kHorizon, east_and_west));
}

TEST_F(SampleMeaning, HorizonsTakeTheUnitOfTheirAngles) {
  const auto horizons_in = [](const std::string& unit, double factor) {
    std::vector<float> samples;
    for (std::size_t i = 0; i < 2 * kCount; ++i) samples.push_back(static_cast<float>(factor * (0.1 + 0.001 * static_cast<double>(i))));
    RawTiff tiff;
    tiff.page(page_of(samples, 2)).utm33();
    if (!unit.empty()) tiff.text(kMetadata, noted(item(0, "unittype", unit) + item(1, "unittype", unit)));
    return tiff;
  };
  const auto tiles_with = [&](const RawTiff& tiff, const channels::Options& options) {
    build_from(tiff, of(ChannelType::kHorizon, options));
    return tiles_of(store_, "horizon");
  };
  const double degrees = 57.29577951308232;
  const channels::Options none{{"azimuths", "90,270"}};
  const channels::Options in_degrees{{"azimuths", "90,270"}, {"angles", "deg"}};
  const channels::Options in_radians{{"azimuths", "90,270"}, {"angles", "rad"}};
  const Tiles wanted = tiles_with(horizons_in("", degrees), in_degrees);
  EXPECT_TRUE(tiles_with(horizons_in("Degrees", degrees), none) == wanted);
  EXPECT_TRUE(tiles_with(horizons_in("deg", degrees), none) == wanted);
  EXPECT_FALSE(tiles_with(horizons_in("", 1.0), none) == Tiles{});
  EXPECT_TRUE(tiles_with(horizons_in("radian", 1.0), none) == tiles_with(horizons_in("", 1.0), none));
  EXPECT_TRUE(tiles_with(horizons_in("deg", 1.0), in_radians) == tiles_with(horizons_in("", 1.0), none)) << "who gives a unit knows better";
  const std::string refused = refusal(horizons_in("gon", 60.0), of(ChannelType::kHorizon, none));
  EXPECT_NE(refused.find("'gon'"), std::string::npos) << refused;
  EXPECT_NE(refused.find("`angles`"), std::string::npos) << refused;
}

// A layer has one scale and one unit for all its bands, so bands that differ cannot be one.
TEST_F(SampleMeaning, BandsThatDeclareDifferentNumbersAreRefused) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<float>(2 * kCount, 0.5F), 2))
      .utm33()
      .text(kMetadata, noted(item(0, "scale", "1") + item(1, "scale", "0.5")));
  const channels::Options east_and_west{{"azimuths", "90,270"}};
  const std::string refused = refusal(tiff, of(ChannelType::kHorizon, east_and_west));
  EXPECT_NE(refused.find("bands 1 and 2"), std::string::npos) << refused;
  EXPECT_NE(refused.find("gdal_translate"), std::string::npos) << refused;
}

TEST_F(SampleMeaning, AScaleThatAChannelDoesNotUseIsMentioned) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<std::uint8_t>(kCount, 40))).utm33().text(kMetadata, noted(item(0, "scale", "0.5")));
  EXPECT_NE(warnings(tiff, of(ChannelType::kColor)).find("scale of 0.5"), std::string::npos);
  EXPECT_NE(warnings(tiff, of(ChannelType::kMaterial)).find("scale of 0.5"), std::string::npos);
}

TEST_F(SampleMeaning, SixDigitsOfTheLowestFloatAreEnough) {
  std::vector<float> samples(kCount, 50.0F);
  for (std::size_t i = 0; i < 20; ++i) samples[i] = std::numeric_limits<float>::lowest();
  RawTiff tiff;
  tiff.page(page_of(samples)).utm33().text(kNodata, "-3.40282e+38");
  const LevelValues heights = build_from(tiff, of(ChannelType::kElevation));
  int voids = 0;
  for (std::int64_t y = 0; y < kSide; ++y)
    for (std::int64_t x = 0; x < kSide; ++x) voids += heights.is_void(x, y) ? 1 : 0;
  EXPECT_EQ(voids, 20);
}

TEST_F(SampleMeaning, AColourKeyIsClear) {
  std::vector<std::uint8_t> samples;
  for (std::size_t i = 0; i < kCount; ++i) samples.insert(samples.end(), {255, 255, static_cast<std::uint8_t>(i % 2 == 0 ? 252 : 255)});
  RawTiff tiff;
  tiff.page(page_of(samples, 3, 2)).utm33();
  LayerRequest request = of(ChannelType::kColor);
  request.sources[0].nodata = {255.0, 255.0, 252.0};
  const LevelValues texels = build_from(tiff, request);
  EXPECT_EQ(layer_.format, TexelFormat::kRgba8);
  EXPECT_EQ(texels.at(0, 0, 3), 0.0);
  EXPECT_EQ(texels.at(1, 0, 3), 255.0);
  request.sources[0].nodata = {255.0, 252.0};
  EXPECT_NE(refusal(tiff, request).find("2 no-data values"), std::string::npos);
}

TEST_F(SampleMeaning, WholeNumbersInFloatsAreClasses) {
  std::vector<float> samples(kCount, 3.0F);
  samples[5] = 12.0F;
  samples[6] = std::numeric_limits<float>::quiet_NaN();
  samples[7] = -1.0F;
  RawTiff tiff;
  tiff.page(page_of(samples)).utm33().text(kNodata, "-1");
  LayerRequest request = of(ChannelType::kMaterial);
  request.format = TexelFormat::kR8;
  const LevelValues classes = build_from(tiff, request);
  EXPECT_EQ(classes.at(4, 0), 3.0);
  EXPECT_EQ(classes.at(5, 0), 12.0);
  EXPECT_EQ(classes.at(6, 0), 255.0);
  EXPECT_EQ(classes.at(7, 0), 255.0);
  // What lies between two classes is none.
  samples[7] = 3.0F;
  samples[9] = 3.5F;
  RawTiff between;
  between.page(page_of(samples)).utm33();
  between.write(folder_ / "between.tif");
  request.sources[0].path = folder_ / "between.tif";
  auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  auto writer = open_or_create(folder_ / "between.vts", plan->crs, plan->extent());
  ASSERT_TRUE(writer.has_value());
  const auto report = build_layer(*writer, *plan, {});
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(report.error().message.find("3.5"), std::string::npos) << report.error().message;
}

TEST_F(SampleMeaning, WhatIsNotUsedIsSaidOnceByName) {
  RawTiff tiff;
  tiff.page(page_of(std::vector<std::uint8_t>(3 * kCount, 40), 3, 2)).utm33().text(34675, "a profile");
  for (const char* name : {"a.tif", "b.tif", "c.tif"}) tiff.write(folder_ / name);
  LayerRequest request = request_for({folder_ / "a.tif", folder_ / "b.tif", folder_ / "c.tif"}, ChannelType::kColor);
  const auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  const auto about =
      std::ranges::count_if(plan->warnings, [](const std::string& text) { return text.find("ICC profile") != std::string::npos; });
  EXPECT_EQ(about, 1);
  const auto remark =
      std::ranges::find_if(plan->warnings, [](const std::string& text) { return text.find("ICC profile") != std::string::npos; });
  EXPECT_NE(remark->find("a.tif and 2 more files"), std::string::npos) << *remark;
  // A profile of colours means nothing to masks.
  LayerRequest mask = of(ChannelType::kMask);
  EXPECT_NE(refusal(tiff, mask).find("has 3 bands of values, and mask takes one"), std::string::npos);
  mask.sources[0].bands = {1};
  EXPECT_EQ(warnings(tiff, mask).find("ICC"), std::string::npos);
}

}  // namespace
}  // namespace vt::pipeline
