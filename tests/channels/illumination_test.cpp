#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "builder/channels/all_channels.h"
#include "store/texel/texel_decoder.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

MadeCodec made(const SampleLayout& layout, TexelFormat format, const Options& options = {}) {
  return make_codec({.channel = ChannelType::kIllumination, .format = format, .options = options}, layout);
}

// What is read back of `samples`, one row. In bc6h the texels before the blocks.
template <class T>
std::vector<float> there_and_back(const SampleLayout& layout, TexelFormat format, const std::vector<T>& samples,
                                  const Options& options = {}) {
  const auto codec = made(layout, format, options);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  const auto count = static_cast<std::int64_t>(samples.size()) / (layout.value_bands + (layout.has_alpha ? 1 : 0));
  Rows rows(count);
  const bool opaque = (*codec)->decode_row(bytes_of(samples), count, rows.row(1));
  const FormatInfo& info = format_info((*codec)->parts()[0].texel_format);
  std::vector<std::byte> texels(static_cast<std::size_t>(count) * info.block_bytes);
  EXPECT_TRUE((*codec)->encode_row(0, rows.middle(opaque), count, texels.data()).has_value());
  std::vector<float> read(static_cast<std::size_t>(count) * info.channels);
  store::decode_texels(info.format, texels, static_cast<std::size_t>(count), 1, read);
  return read;
}

constexpr std::array kFormats{TexelFormat::kRgba32Float, TexelFormat::kRgba16Float, TexelFormat::kRgb9e5, TexelFormat::kBc6h};

TEST(IlluminationCodec, CodesAreAShareOfTheScaleAndAreMadeLinearFirst) {
  const auto linear =
      there_and_back({.value_bands = 1}, TexelFormat::kRgba32Float, std::vector<std::uint8_t>{0, 51, 255}, {{"scale", "40"}});
  EXPECT_EQ(linear, (std::vector<float>{0, 0, 0, 1, 8, 8, 8, 1, 40, 40, 40, 1}));
  const auto srgb = there_and_back({.type = SampleType::kUint16, .value_bands = 3}, TexelFormat::kRgba32Float,
                                   std::vector<std::uint16_t>{65535, 32768, 0}, {{"transfer", "srgb"}, {"scale", "2"}});
  EXPECT_EQ(srgb[0], 2.0F);
  EXPECT_FLOAT_EQ(srgb[1], static_cast<float>(2.0 * std::pow((32768.0 / 65535.0 + 0.055) / 1.055, 2.4)));
  EXPECT_EQ(srgb[2], 0.0F);
}

TEST(IlluminationCodec, NumbersOfEveryTypeAreLightTimesTheScale) {
  for (const TexelFormat format : kFormats) {
    const auto halves =
        there_and_back({.type = SampleType::kFloat32, .value_bands = 3}, format, std::vector<float>{0.5F, 0.25F, 1.0F}, {{"scale", "4"}});
    EXPECT_EQ((std::vector<float>{halves.begin(), halves.begin() + 3}), (std::vector<float>{2, 1, 4})) << format_info(format).name;
    const auto whole = there_and_back({.type = SampleType::kInt16, .value_bands = 1}, format, std::vector<std::int16_t>{12});
    EXPECT_EQ(whole[1], 12.0F) << "a signed integer is a number, not a code";
  }
  const auto doubles =
      there_and_back({.type = SampleType::kFloat64, .value_bands = 1}, TexelFormat::kRgba32Float, std::vector<double>{1e300});
  EXPECT_EQ(doubles[0], std::numeric_limits<float>::max());
}

TEST(IlluminationCodec, NegativeLightIsNoneAndWhatIsNotFiniteIsNoData) {
  const float inf = std::numeric_limits<float>::infinity();
  const auto light = there_and_back({.type = SampleType::kFloat32, .value_bands = 1, .nodata = -1.0}, TexelFormat::kRgba16Float,
                                    std::vector<float>{-3.0F, 7.0F, std::nanf(""), 5.0F, -inf, 9.0F, -1.0F});
  const std::vector<float> wanted{0, 1, 7, 1, 6, 0, 5, 1, 7, 0, 9, 1, 9, 0};  // light and coverage; holes have their neighbours' light
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(light[i * 4 + 1], wanted[i * 2]) << i;
    EXPECT_EQ(light[i * 4 + 3], wanted[i * 2 + 1]) << i;
  }
  for (const TexelFormat format : {TexelFormat::kRgb9e5, TexelFormat::kBc6h}) {
    const auto dark = there_and_back({.type = SampleType::kFloat32, .value_bands = 1}, format, std::vector<float>{inf, 8.0F});
    EXPECT_EQ(dark[0], 0.0F) << "no coverage to say it with: no light";
  }
}

TEST(IlluminationCodec, ExtremesStayInRangeInEveryFormat) {
  for (const TexelFormat format : kFormats) {
    const float limit = format == TexelFormat::kRgba32Float ? 1e30F : format == TexelFormat::kRgb9e5 ? 65408.0F : 65504.0F;
    const auto light = there_and_back({.type = SampleType::kFloat32, .value_bands = 1}, format,
                                      std::vector<float>{1e30F, 65519.0F, 1e-40F, std::numeric_limits<float>::denorm_min(), 0.0F});
    const std::size_t step = light.size() / 5;
    EXPECT_EQ(light[0], limit) << format_info(format).name;
    EXPECT_EQ(light[step], std::min(limit, 65519.0F));
    EXPECT_EQ(light[2 * step], format == TexelFormat::kRgba32Float ? 1e-40F : 0.0F);
    EXPECT_EQ(light[4 * step], 0.0F);
  }
}

TEST(IlluminationCodec, CoverageIsStoredBesideLightOrMultipliedIntoIt) {
  const std::vector<std::uint8_t> half_covered{255, 0, 51, 102};  // coverage 0.4
  const SampleLayout layout{.value_bands = 3, .has_alpha = true};
  const auto beside = there_and_back(layout, TexelFormat::kRgba32Float, half_covered, {{"scale", "10"}});
  EXPECT_FLOAT_EQ(beside[0], 10.0F);
  EXPECT_FLOAT_EQ(beside[2], 2.0F);
  EXPECT_EQ(beside[3], 0.4F);
  const auto into = there_and_back(layout, TexelFormat::kRgb9e5, half_covered, {{"scale", "10"}});
  EXPECT_FLOAT_EQ(into[0], 4.0F);
  EXPECT_NEAR(into[2], 0.8F, 4.0F / 512) << "half a step of the mantissa that all three share";
}

TEST(IlluminationCodec, WhatIsCutOffIsReportedAndTheTotalFalls) {
  const SampleLayout layout{.type = SampleType::kFloat32, .value_bands = 1};
  const auto codec = made(layout, TexelFormat::kRgba16Float);
  Rows rows(2);
  const std::vector<float> samples{100000.0F, 100.0F};
  (*codec)->decode_row(bytes_of(samples), 2, rows.row(1));
  const std::vector<float> stored{65504, 65504, 65504, 1, 100, 100, 100, 1};
  std::vector<ErrorSum> errors((*codec)->measures().size());
  (*codec)->add_errors(0, rows.middle(true).here, stored.data(), 2, errors);
  EXPECT_EQ((*codec)->measures()[1].name, "clipped light");
  EXPECT_EQ(errors[1].count, 6U);
  EXPECT_EQ(errors[1].largest, 100000.0 - 65504.0);
  EXPECT_EQ(errors[0].reference_total, 3 * 100100.0);
  EXPECT_EQ(errors[0].stored_total, 3 * 65604.0);
}

TEST(IlluminationCodec, TheMeanOfSamplesTooLargeToAddIsRefused) {
  for (const TexelFormat format : kFormats) {
    const auto codec = made({.type = SampleType::kFloat32, .value_bands = 1}, format);
    Rows rows(2);
    (*codec)->decode_row(bytes_of(std::vector<float>{1.0F, 2.0F}), 2, rows.row(1));
    rows.row(1)[2][1] = std::numeric_limits<float>::infinity();
    std::array<std::byte, 32> texels{};
    const auto done = (*codec)->encode_row(0, rows.middle(true), 2, texels.data());
    ASSERT_FALSE(done.has_value()) << format_info(format).name;
    EXPECT_EQ(done.error().code, ErrorCode::kInvalidData);
    EXPECT_NE(done.error().message.find("`nodata`"), std::string::npos);
  }
}

// A power of two moves exponents: light in another unit has the same codes and another scale.
TEST(IlluminationCodec, AStoredScaleIsTheSameLightInAnotherUnit) {
  std::vector<float> samples{0.0F, 1.0F, 0.7F, 12.5F, 900.0F, 0x1p-13F, 3e-5F};
  std::vector<float> small;
  for (const float sample : samples) small.push_back(std::ldexp(sample, -20));
  const SampleLayout layout{.type = SampleType::kFloat32, .value_bands = 1};
  for (const TexelFormat format : kFormats) {
    const auto scaled = made(layout, format, {{"stored-scale", "9.5367431640625e-07"}});
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ((*scaled)->parts()[0].ranges[c].scale, 0x1p-20);
    EXPECT_EQ((*scaled)->parts()[0].ranges[3].scale, 1.0) << "coverage has none";
    EXPECT_EQ(there_and_back(layout, format, small, {{"stored-scale", "9.5367431640625e-07"}}), there_and_back(layout, format, samples))
        << format_info(format).name;
  }
  // What a plan chooses for a layer counts unless the user does.
  const ChannelSettings settings{.channel = ChannelType::kIllumination, .format = TexelFormat::kRgb9e5, .stored_light = 0.25};
  EXPECT_EQ((*make_codec(settings, layout))->parts()[0].ranges[0].scale, 0.25);
}

TEST(IlluminationCodec, ErrorsAreInTheUnitOfLightWhateverTheScale) {
  const auto codec = made({.type = SampleType::kFloat32, .value_bands = 1}, TexelFormat::kRgb9e5, {{"stored-scale", "0.125"}});
  Rows rows(2);
  (*codec)->decode_row(bytes_of(std::vector<float>{8.0F, 10000.0F}), 2, rows.row(1));
  const std::vector<float> stored{64, 64, 72, 65408, 65408, 65408};
  std::vector<ErrorSum> errors(2);
  (*codec)->add_errors(0, rows.middle(true).here, stored.data(), 2, errors);
  EXPECT_EQ(errors[0].largest, 10000.0 - 65408.0 / 8);
  EXPECT_EQ(errors[1].largest, 10000.0 - 65408.0 / 8) << "cut off at the largest number times the scale";
  EXPECT_EQ(errors[0].sum, 1.0 + 3 * (10000.0 - 65408.0 / 8));
}

TEST(IlluminationCodec, LightThatIsCutOffOrLostIsCounted) {
  const std::vector<float> samples{70000.0F, 1.0F, 1e-8F, 0.0F, std::nanf("")};
  for (const TexelFormat format : kFormats) {
    const auto codec = made({.type = SampleType::kFloat32, .value_bands = 1}, format);
    Rows rows(5);
    const bool opaque = (*codec)->decode_row(bytes_of(samples), 5, rows.row(1));
    std::vector<LossCount> counts((*codec)->losses().size());
    (*codec)->count_losses(rows.middle(opaque).here, opaque, 5, 0, 3, counts);
    if (format == TexelFormat::kRgba32Float) {
      EXPECT_TRUE(counts.empty());
      continue;
    }
    ASSERT_EQ(counts.size(), format == TexelFormat::kRgba16Float ? 2U : 3U);
    EXPECT_EQ(counts[0].texels, 1U) << "more than the format holds";
    EXPECT_EQ(counts[0].x, 0);
    EXPECT_EQ(counts[1].texels, 1U) << "less than half of the least number above nothing";
    EXPECT_EQ(counts[1].x, 2);
    if (counts.size() > 2) {
      EXPECT_EQ(counts[2].x, 4) << "no data is darkness";
    }
  }
}

TEST(IlluminationCodec, OutsideIsUncoveredOrDark) {
  for (const TexelFormat format : {TexelFormat::kRgba32Float, TexelFormat::kRgba16Float, TexelFormat::kRgb9e5}) {
    const auto codec = made({.value_bands = 1}, format);
    const FormatInfo& info = format_info((*codec)->parts()[0].texel_format);
    std::vector<std::byte> texels(std::size_t{2} * info.block_bytes, std::byte{0x12});
    (*codec)->mark_outside(0, texels.data(), 2);
    std::vector<float> read(std::size_t{2} * info.channels);
    store::decode_texels(info.format, texels, 2, 1, read);
    EXPECT_EQ(read[info.channels == 4 ? 3 : 0], 0.0F) << info.name;
    EXPECT_EQ(read.back(), 0.0F) << info.name;
    EXPECT_EQ(read[0] > 0.0F, format != TexelFormat::kRgb9e5) << info.name;
  }
}

TEST(IlluminationCodec, RefusesWhatCannotHoldLightAndSaysWhatCan) {
  const auto message = [](const MadeCodec& codec) { return codec ? std::string("made") : codec.error().message; };
  for (const TexelFormat format : {TexelFormat::kRgba8, TexelFormat::kBc1, TexelFormat::kBc7, TexelFormat::kR16})
    EXPECT_NE(message(made({.value_bands = 3}, format)).find("use rgba32f, rgba16f, rgb9e5 or bc6h"), std::string::npos);
  EXPECT_NE(message(made({.value_bands = 2}, TexelFormat::kRgb9e5)).find("one band or three"), std::string::npos);
  EXPECT_NE(message(made({.type = SampleType::kFloat32}, TexelFormat::kRgb9e5, {{"transfer", "srgb"}})).find("leave `transfer` out"),
            std::string::npos);
  EXPECT_NE(message(made({}, TexelFormat::kRgb9e5, {{"scale", "0"}})).find("option scale"), std::string::npos);
  EXPECT_NE(message(made({.range = {{0.0, 1.0}}}, TexelFormat::kRgb9e5)).find("`scale`"), std::string::npos);
}

TEST(IlluminationCodec, TheUnitIsThatOfRadianceUnlessLightIsRelative) {
  const auto unit = [](SampleType type, const Options& options) {
    return (*made({.type = type, .value_bands = 1}, TexelFormat::kRgb9e5, options))->parts()[0].unit;
  };
  EXPECT_EQ(unit(SampleType::kUint8, {}), "");
  EXPECT_EQ(unit(SampleType::kUint8, {{"scale", "3"}}), "W/(m2 sr)");
  EXPECT_EQ(unit(SampleType::kFloat32, {}), "W/(m2 sr)");
  EXPECT_EQ(unit(SampleType::kFloat32, {{"unit", "nW/(cm2 sr)"}}), "nW/(cm2 sr)");
}

}  // namespace
}  // namespace vt::channels
