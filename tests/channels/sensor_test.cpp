#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "builder/channels/channel_makers.h"
#include "builder/channels/planck.h"
#include "store/texel_decoder.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

MadeCodec made(const SampleLayout& layout, TexelFormat format, const Options& options) {
  return make_codec({.channel = ChannelType::kSensor, .format = format, .options = options}, layout);
}

// What the stored numbers of `samples` are worth, one row; of blocks, before they are made.
template <class T>
std::vector<double> there_and_back(const SampleLayout& layout, TexelFormat format, const std::vector<T>& samples, const Options& options) {
  const auto codec = made(layout, format, options);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = (*codec)->decode_row(bytes_of(samples), count, rows.row(1));
  const Part& part = (*codec)->parts()[0];
  const FormatInfo& info = format_info(part.texel_format);
  std::vector<std::byte> texels(samples.size() * info.block_bytes);
  EXPECT_TRUE((*codec)->encode_row(0, rows.middle(opaque), count, texels.data()).has_value());
  std::vector<float> read(samples.size());
  store::decode_texels(info.format, texels, samples.size(), 1, read);
  std::vector<double> values;
  // Blocks decode to 255 where their texels have 65535.
  const double unblocked = format == TexelFormat::kBc4 ? 255.0 / 65535.0 : 1.0;
  for (const float sample : read)
    values.push_back(part.zero_is_nodata && sample == 0.0F ? std::nan("")
                                                           : part.ranges[0].offset + part.ranges[0].scale * sample * unblocked);
  return values;
}

const SampleLayout kFloats{.type = SampleType::kFloat32, .value_bands = 1};
const Options kKelvins{{"quantity", "temperature"}, {"band", "8,12"}, {"store", "temperature"}};

TEST(SensorCodec, TemperaturesBecomeRadianceAndComeBack) {
  const BandRadiance band({{8.0, 1.0}, {12.0, 1.0}});
  const std::vector<float> kelvins{180.0F, 273.15F, 300.0F, 800.0F, 1500.0F, 90.0F, 3500.0F};
  const auto radiance = there_and_back(kFloats, TexelFormat::kR32Float, kelvins, {{"quantity", "temperature"}, {"band", "8,12"}});
  const auto back = there_and_back(kFloats, TexelFormat::kR32Float, kelvins, kKelvins);
  for (std::size_t i = 0; i < kelvins.size(); ++i) {
    EXPECT_EQ(static_cast<float>(radiance[i]), static_cast<float>(band.radiance(kelvins[i])));
    EXPECT_NEAR(back[i], kelvins[i], 1e-3);
  }
}

TEST(SensorCodec, CodesHaveTheirScaleAndOffset) {
  Options options = kKelvins;
  options["input-scale"] = "0.00341802";
  options["input-offset"] = "149";
  const auto kelvins = there_and_back({.type = SampleType::kUint16, .value_bands = 1, .nodata = 0.0}, TexelFormat::kR32Float,
                                      std::vector<std::uint16_t>{0, 44177, 65535}, options);
  EXPECT_TRUE(std::isnan(kelvins[0]));
  EXPECT_NEAR(kelvins[1], 300.0, 1e-3 + 0.00341802);
  EXPECT_NEAR(kelvins[2], 149.0 + 65535 * 0.00341802, 1e-3);
  const auto celsius = there_and_back(
      {.type = SampleType::kInt16, .value_bands = 1}, TexelFormat::kR32Float, std::vector<std::int16_t>{-4000, 0, 2500},
      {{"quantity", "temperature"}, {"band", "8,12"}, {"store", "temperature"}, {"input-scale", "0.01"}, {"input-offset", "273.15"}});
  EXPECT_NEAR(celsius[0], 233.15, 1e-3);
  EXPECT_NEAR(celsius[2], 298.15, 1e-3);
  const auto ratio = there_and_back({.type = SampleType::kInt8, .value_bands = 1}, TexelFormat::kR32Float,
                                    std::vector<std::int8_t>{-1, 100}, {{"quantity", "reflectance"}, {"input-scale", "0.01"}});
  EXPECT_NEAR(ratio[0], -0.01, 1e-9) << "noise below 0 stays, or the mean would be too bright";
  EXPECT_NEAR(ratio[1], 1.0, 1e-7);
}

TEST(SensorCodec, WhatIsNoTemperatureIsNoData) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> samples{0.0F, -5.0F, std::nanf(""), inf, -inf, 1e30F, 290.0F};
  for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16}) {
    Options options = kKelvins;
    options["span"] = "180,400";
    const auto kelvins = there_and_back(kFloats, format, samples, options);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(std::isnan(kelvins[i])) << i;
    EXPECT_TRUE(std::isnan(kelvins[5]) || format == TexelFormat::kR16) << "no temperature is known for it";
    EXPECT_NEAR(kelvins[6], 290.0, 0.13) << "half a step of a half";
  }
  const auto dark = there_and_back(kFloats, TexelFormat::kR32Float, std::vector<float>{-1.0F, 0.0F, 20.0F, 1e30F},
                                   {{"band", "8,12"}, {"store", "temperature"}});
  EXPECT_TRUE(std::isnan(dark[0]));
  EXPECT_TRUE(std::isnan(dark[1]));
  EXPECT_GT(dark[2], 250.0);
  EXPECT_TRUE(std::isnan(dark[3]));
}

TEST(SensorCodec, CodesSpanWhatWasSaidAndClipTheRest) {
  for (const TexelFormat format : {TexelFormat::kR16, TexelFormat::kBc4}) {
    const auto values = there_and_back(kFloats, format, std::vector<float>{-1.0F, 2.0F, 5.0F, 12.0F, 99.0F}, {{"span", "2,12"}});
    EXPECT_NEAR(values[0], 2.0, 1e-12);
    EXPECT_NEAR(values[1], 2.0, 1e-12);
    EXPECT_NEAR(values[2], 5.0, 0.5 * 10.0 / 65534);
    EXPECT_NEAR(values[3], 12.0, 1e-12);
    EXPECT_NEAR(values[4], 12.0, 1e-12);
  }
}

TEST(SensorCodec, BlocksTakeTheirNeighboursWhereThereIsNoData) {
  const auto values =
      there_and_back(kFloats, TexelFormat::kBc4, std::vector<float>{0.25F, std::nanf(""), 0.75F, std::nanf(""), std::nanf("")},
                     {{"quantity", "reflectance"}});
  EXPECT_NEAR(values[1], 0.5, 1e-5);
  EXPECT_NEAR(values[3], 0.75, 1e-5);
  EXPECT_EQ(values[4], 0.0);
}

TEST(SensorCodec, ErrorsAreInTheUnitOfWhatIsStoredAndInKelvins) {
  const auto codec = made(kFloats, TexelFormat::kR32Float, {{"quantity", "temperature"}, {"band", "8,12"}});
  ASSERT_EQ((*codec)->measures().size(), 3U);
  EXPECT_EQ((*codec)->measures()[0].unit, "W/(m2 sr)");
  EXPECT_EQ((*codec)->measures()[2].unit, "K");
  const BandRadiance band({{8.0, 1.0}, {12.0, 1.0}});
  Rows rows(1);
  const std::vector<float> samples{300.0F};
  (*codec)->decode_row(bytes_of(samples), 1, rows.row(1));
  const auto stored = static_cast<float>(band.radiance(301.0));
  std::vector<ErrorSum> errors(3);
  (*codec)->add_errors(0, rows.middle(true).here, &stored, 1, errors);
  EXPECT_NEAR(errors[0].largest, band.radiance(301.0) - band.radiance(300.0), 1e-5);
  EXPECT_EQ(errors[1].largest, 0.0);
  EXPECT_NEAR(errors[2].largest, 1.0, 1e-4);
  EXPECT_NEAR(errors[0].stored_total / errors[0].reference_total, band.radiance(301.0) / band.radiance(300.0), 1e-6);
}

TEST(SensorCodec, ReadersAreToldWhatTheyRead) {
  const auto codec = made(kFloats, TexelFormat::kR16, {{"quantity", "temperature"}, {"response", "8,0\n10,1\n12,0\n"}, {"span", "0,60"}});
  const auto metadata = nlohmann::json::parse((*codec)->parts()[0].metadata_json);
  EXPECT_EQ(metadata.at("quantity"), "radiance");
  EXPECT_EQ(metadata.at("input_quantity"), "temperature");
  EXPECT_EQ(metadata.at("band_um"), (std::vector<double>{8.0, 12.0}));
  EXPECT_EQ(metadata.at("response").at("response"), (std::vector<double>{0.0, 1.0, 0.0}));
  EXPECT_TRUE((*codec)->parts()[0].zero_is_nodata);
}

TEST(SensorCodec, RefusesWhatDoesNotFitAndSaysWhatDoes) {
  const auto message = [](const SampleLayout& layout, TexelFormat format, const Options& options) {
    const auto codec = made(layout, format, options);
    return codec ? std::string("made") : codec.error().message;
  };
  const auto says = [&](TexelFormat format, const Options& options, const char* words) {
    EXPECT_NE(message(kFloats, format, options).find(words), std::string::npos) << message(kFloats, format, options);
  };
  says(TexelFormat::kR32Float, {{"quantity", "temperature"}}, "--band LOW,HIGH");
  says(TexelFormat::kR32Float, {{"store", "temperature"}}, "--band LOW,HIGH");
  says(TexelFormat::kR32Float, {{"quantity", "albedo"}}, "none of radiance");
  says(TexelFormat::kR32Float, {{"quantity", "emissivity"}, {"store", "radiance"}}, "option store");
  says(TexelFormat::kR32Float, {{"quantity", "temperature"}, {"band", "8,12"}, {"unit", "F"}}, "option unit");
  says(TexelFormat::kR32Float, {{"input-scale", "0"}}, "option input-scale");
  says(TexelFormat::kR16, {}, "--span LOW,HIGH");
  says(TexelFormat::kR16, {{"span", "5,5"}}, "option span");
  says(TexelFormat::kBc1, {}, "use r32f, r16f, r16 or bc4");
  EXPECT_NE(message({.type = SampleType::kFloat32, .value_bands = 3}, TexelFormat::kR32Float, {}).find("--bands"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
