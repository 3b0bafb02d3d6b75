#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "builder/channels/all_channels.h"
#include "builder/channels/sensor/planck.h"
#include "store/texel/texel_decoder.h"
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

// What four texels of `value` become when their sum is beyond all floats: planes of infinity.
TEST(SensorCodec, TheMeanOfSamplesTooLargeToAddIsRefused) {
  for (const TexelFormat format : {TexelFormat::kR32Float, TexelFormat::kR16Float, TexelFormat::kR16, TexelFormat::kBc4})
    for (const bool is_opaque : {true, false}) {
      const auto codec = made(kFloats, format, {{"span", "0,1"}});
      Rows rows(3);
      (*codec)->decode_row(bytes_of(std::vector<float>{1.0F, 2.0F, 3.0F}), 3, rows.row(1));
      rows.row(1)[0][1] = std::numeric_limits<float>::infinity();
      std::vector<std::byte> texels(3 * 8);
      const auto done = (*codec)->encode_row(0, rows.middle(is_opaque), 3, texels.data());
      ASSERT_FALSE(done.has_value()) << format_info(format).name;
      EXPECT_EQ(done.error().code, ErrorCode::kInvalidData);
      EXPECT_NE(done.error().message.find("`nodata`"), std::string::npos);
    }
}

TEST(SensorCodec, NoErrorIsNoNumberWhereRadianceHasNoTemperature) {
  const auto codec = made(kFloats, TexelFormat::kR16Float, {{"band", "8,12"}});
  ASSERT_EQ((*codec)->measures()[2].name, "equivalent temperature");
  // More than a body of 10^7 K radiates, and next to nothing.
  const std::vector<float> samples{1e30F, 1e-30F, 20.0F};
  Rows rows(3);
  (*codec)->decode_row(bytes_of(samples), 3, rows.row(1));
  const std::vector<float> stored{65504.0F, 0.0F, 20.0F};
  std::vector<ErrorSum> errors(3);
  (*codec)->add_errors(0, rows.middle(true).here, stored.data(), 3, errors);
  for (const ErrorSum& error : errors)
    for (const double number : {error.sum, error.sum_squares, error.largest, error.reference_total, error.stored_total})
      EXPECT_TRUE(std::isfinite(number));
  EXPECT_EQ(errors[0].count, 3U);
  EXPECT_EQ(errors[2].count, 2U);
}

struct Counted {
  std::vector<Loss> losses;
  std::vector<LossCount> counts;
};

Counted losses_of(TexelFormat format, const std::vector<float>& samples, const Options& options) {
  const auto codec = made(kFloats, format, options);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = (*codec)->decode_row(bytes_of(samples), count, rows.row(1));
  Counted result{{(*codec)->losses().begin(), (*codec)->losses().end()}, std::vector<LossCount>((*codec)->losses().size())};
  (*codec)->count_losses(rows.middle(opaque).here, opaque, count, 100, 5, result.counts);
  return result;
}

TEST(SensorCodec, WhatIsCutOffIsCounted) {
  const std::vector<float> samples{-100.0F, 0.0F, 1.0F, 1.0F + 1e-6F, 1.01F, std::nanf("")};
  const Counted codes = losses_of(TexelFormat::kR16, samples, {{"quantity", "reflectance"}});
  ASSERT_EQ(codes.counts.size(), 1U);
  EXPECT_EQ(codes.counts[0].texels, 2U) << "less than half a step beyond an end lies on it";
  EXPECT_EQ(codes.counts[0].x, 100);
  EXPECT_EQ(codes.counts[0].y, 5);
  EXPECT_NE(codes.losses[0].what.find("outside 0 to 1, what `span` gives r16"), std::string::npos) << codes.losses[0].what;
  const Counted halves = losses_of(TexelFormat::kR16Float, {65504.0F, 65519.0F, 65521.0F, -65521.0F}, {});
  ASSERT_EQ(halves.counts.size(), 1U);
  EXPECT_EQ(halves.counts[0].texels, 2U);
  EXPECT_NE(halves.losses[0].what.find("65504 W/(m2 sr)"), std::string::npos) << halves.losses[0].what;
  EXPECT_TRUE(losses_of(TexelFormat::kR32Float, samples, {}).losses.empty());

  Options kelvins = kKelvins;
  kelvins["span"] = "200,300";
  const Counted temperatures = losses_of(TexelFormat::kR16, {150.0F, 200.0F, 299.0F, 301.0F, 400.0F}, kelvins);
  ASSERT_EQ(temperatures.counts.size(), 2U);
  EXPECT_EQ(temperatures.counts[0].texels, 0U);
  EXPECT_EQ(temperatures.counts[1].texels, 3U);
  EXPECT_NE(temperatures.losses[1].what.find("200 to 300 K"), std::string::npos) << temperatures.losses[1].what;
  const Counted dark = losses_of(TexelFormat::kR32Float, {-1.0F, 0.0F, 20.0F, 1e30F}, {{"band", "8,12"}, {"store", "temperature"}});
  ASSERT_EQ(dark.counts.size(), 1U);
  EXPECT_EQ(dark.counts[0].texels, 3U);
  const Counted blocks = losses_of(TexelFormat::kBc4, samples, {{"quantity", "reflectance"}});
  ASSERT_EQ(blocks.counts.size(), 2U);
  EXPECT_EQ(blocks.counts[0].texels, 1U) << "bc4 has no code for no data";
  EXPECT_EQ(blocks.counts[1].texels, 2U);
}

TEST(SensorCodec, WideSamplesAreCodesToHalfAStepAndErrorsAreMeasuredAgainstThem) {
  const double low = 999999.99, high = 1000000.01;
  const ChannelSettings settings{.channel = ChannelType::kSensor,
                                 .format = TexelFormat::kR16,
                                 .samples_are_wide = true,
                                 .options = {{"span", "999999.99,1000000.01"}, {"unit", "x"}}};
  const auto codec = make_codec(settings, {.type = SampleType::kFloat64, .value_bands = 1});
  ASSERT_TRUE(codec.has_value()) << codec.error().message;
  EXPECT_EQ((*codec)->source_planes(), 3);
  EXPECT_EQ((*codec)->rules()[1], PlaneRule::kRemainder);
  std::vector<double> samples;
  for (int i = 0; i <= 100; ++i) samples.push_back(low + (high - low) * i / 100.0);
  Rows rows(101);
  EXPECT_TRUE((*codec)->decode_row(bytes_of(samples), 101, rows.row(1)));
  std::vector<std::uint16_t> codes(101);
  ASSERT_TRUE((*codec)->encode_row(0, rows.middle(true), 101, reinterpret_cast<std::byte*>(codes.data())).has_value());
  const ComponentRange range = (*codec)->parts()[0].ranges[0];
  // Planes hold 48 bits: 3.6e-9 of 10^6.
  for (std::size_t i = 0; i < 101; ++i)
    EXPECT_NEAR(range.offset + range.scale * codes[i], samples[i], 0.5 * range.scale + 4e-9) << samples[i];
  // Deliberately wrong by a thousandth.
  std::vector<float> stored(101);
  for (std::size_t i = 0; i < 101; ++i) stored[i] = static_cast<float>((samples[i] + 0.001 - range.offset) / range.scale);
  std::vector<ErrorSum> errors((*codec)->measures().size());
  (*codec)->add_errors(0, rows.middle(true).here, stored.data(), 101, errors);
  EXPECT_NEAR(errors[0].mean(), 0.001, 1e-7);
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
  says(TexelFormat::kR32Float, {{"quantity", "temperature"}}, "`band` LOW,HIGH");
  says(TexelFormat::kR32Float, {{"store", "temperature"}}, "`band` LOW,HIGH");
  says(TexelFormat::kR32Float, {{"quantity", "albedo"}}, "none of radiance");
  says(TexelFormat::kR32Float, {{"quantity", "emissivity"}, {"store", "radiance"}}, "option store");
  says(TexelFormat::kR32Float, {{"quantity", "temperature"}, {"band", "8,12"}, {"unit", "F"}}, "option unit");
  says(TexelFormat::kR32Float, {{"input-scale", "0"}}, "option input-scale");
  says(TexelFormat::kR16, {}, "`span` LOW,HIGH");
  says(TexelFormat::kR16, {{"span", "5,5"}}, "option span");
  says(TexelFormat::kBc1, {}, "use r32f, r16f, r16 or bc4");
  EXPECT_NE(message({.type = SampleType::kFloat32, .value_bands = 3}, TexelFormat::kR32Float, {}).find("`bands`"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
