#include "builder/channels/horizon/horizon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "builder/channels/all_channels.h"
#include "builder/channels/horizon/horizon_input.h"
#include "builder/channels/horizon/lit_fraction.h"
#include "builder/channels/shared/angle.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

constexpr double kDeg = kRadiansPerDegree;

MadeCodec try_codec(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  return make_codec({.channel = ChannelType::kHorizon, .format = format, .options = options}, layout);
}

std::unique_ptr<const ChannelCodec> codec_for(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  auto codec = try_codec(format, layout, options);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return codec ? std::move(*codec) : nullptr;
}

std::string refusal(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  auto codec = try_codec(format, layout, options);
  return codec ? "" : codec.error().message;
}

SampleLayout floats(int bands) { return {.type = SampleType::kFloat32, .value_bands = bands}; }

struct Decoded {
  template <class T>
  Decoded(const ChannelCodec& codec, const std::vector<T>& samples, int bands)
      : count(static_cast<std::int64_t>(samples.size()) / bands), rows(count) {
    opaque = codec.decode_row(bytes_of(samples), count, rows.row(1));
    codec.derive_row(count, rows.row(1));
  }
  std::int64_t count;
  Rows rows;
  bool opaque = false;
};

// All texels of the row averaged into one, as overviews do; in double, so that only the codec's own rounding
// is seen.
Decoded mean_of(const ChannelCodec& codec, Decoded& all, int bands) {
  Decoded mean(codec, std::vector<float>(static_cast<std::size_t>(bands), 0.0F), bands);
  for (std::size_t p = 0; p < static_cast<std::size_t>(codec.planes()); ++p) {
    double sum = 0.0;
    for (std::int64_t i = 0; i < all.count; ++i) sum += all.rows.row(1)[p][i];
    mean.rows.row(1)[p][0] = static_cast<float>(sum / static_cast<double>(all.count));
  }
  mean.opaque = false;
  return mean;
}

// Codes of a part; `Code` is a sample of its texel_format.
template <class Code>
std::vector<Code> codes_of(const ChannelCodec& codec, std::size_t part, Decoded& row) {
  std::vector<Code> codes(static_cast<std::size_t>(row.count) * codec.parts()[part].components.size());
  EXPECT_TRUE(codec.encode_row(part, row.rows.middle(row.opaque), row.count, reinterpret_cast<std::byte*>(codes.data())).has_value());
  return codes;
}

// In radians, as readers get them.
template <class Code>
std::vector<double> values_of(const ChannelCodec& codec, std::size_t part, Decoded& row) {
  const Part& p = codec.parts()[part];
  const double codes_per_sample = format_info(p.format).samples == SampleKind::kBlock ? 257.0 : 1.0;
  std::vector<double> values;
  for (const Code code : codes_of<Code>(codec, part, row)) {
    const ComponentRange& range = p.ranges[values.size() % p.components.size()];
    values.push_back(range.offset + range.scale * (code / codes_per_sample));
  }
  return values;
}

TEST(LitFraction, IsTheNormalDistribution) {
  // Linear between multiples of 1/128: at most 0.242 / 8 / 128^2 off, 0.242 the steepest second derivative.
  for (double z = -9.0; z <= 9.0; z += 0.00371) EXPECT_NEAR(normal_distribution(z), 0.5 * std::erfc(-z / std::sqrt(2.0)), 1.9e-6) << z;
  EXPECT_EQ(normal_distribution(0.0), 0.5);
  EXPECT_EQ(lit_fraction(0.1, 0.1, 0.0), 0.5) << "half the disc, and nothing divided by 0";
  EXPECT_EQ(lit_fraction(0.1, 0.2, 0.0), 0.0);
  EXPECT_EQ(lit_fraction(0.2, 0.1, 0.0), 1.0);
}

TEST(HorizonCodec, AnglesComeBackWithinHalfAStep) {
  const std::vector<float> degrees{-90, 90, 0, 0, 12.34F, -0.7F, 45, 3.3F, 89.999F, -89.999F};
  const auto check = [&](TexelFormat format, auto code, double step_deg) {
    const auto codec = codec_for(format, floats(2), {{"angles", "deg"}});
    EXPECT_NEAR(codec->parts()[0].ranges[0].scale / kDeg, step_deg, 0.01 * step_deg);
    Decoded row(*codec, degrees, 2);
    ASSERT_TRUE(row.opaque);
    std::vector<double> mean;
    for (std::size_t part = 0; part < codec->parts().size(); ++part) {
      const auto values = values_of<decltype(code)>(*codec, part, row);
      const std::size_t step = codec->parts()[part].components.size();
      for (std::size_t c = 0; c < values.size(); c += 2) {
        const std::size_t direction = step == 4 ? c / 2 % 2 : part;
        const double wanted = degrees[c / step * 2 + direction] * kDeg;
        EXPECT_NEAR(values[c], wanted, 0.505 * step_deg * kDeg) << format_info(format).name;
        EXPECT_EQ(values[c + 1], 0.0) << "one angle has no deviation";
        if (wanted == 0.0 && format != TexelFormat::kBc5) {
          EXPECT_EQ(values[c], 0.0) << "level ground is exact";
        }
      }
    }
  };
  check(TexelFormat::kRgba16, std::uint16_t{}, 180.0 / 65534);
  check(TexelFormat::kRg16, std::uint16_t{}, 180.0 / 65534);
  check(TexelFormat::kRgba8, std::uint8_t{}, 180.0 / 254);
  check(TexelFormat::kRg8, std::uint8_t{}, 180.0 / 254);
  check(TexelFormat::kBc5, std::uint16_t{}, 180.0 / 255);
}

TEST(HorizonCodec, ACoarseTexelHasTheMeanAndDeviationOfTheAnglesUnderIt) {
  std::mt19937 random(11);
  std::gamma_distribution<float> angle(2.0F, 0.09F);
  std::vector<float> samples;
  for (int i = 0; i < 2000; ++i) samples.push_back(std::min(angle(random), 1.5F));
  const auto codec = codec_for(TexelFormat::kRgba16, floats(2));
  Decoded all(*codec, samples, 2);
  Decoded mean = mean_of(*codec, all, 2);
  const auto values = values_of<std::uint16_t>(*codec, 0, mean);
  for (std::size_t d = 0; d < 2; ++d) {
    double sum = 0.0;
    for (std::size_t i = d; i < samples.size(); i += 2) sum += samples[i] / 1000.0;
    double squares = 0.0;
    for (std::size_t i = d; i < samples.size(); i += 2) squares += (samples[i] - sum) * (samples[i] - sum) / 1000.0;
    EXPECT_NEAR(values[2 * d], sum, 0.51 * codec->parts()[0].ranges[0].scale);
    // And the float planes' part, see horizon.cpp.
    EXPECT_NEAR(values[2 * d + 1], std::sqrt(squares), 0.51 * codec->parts()[0].ranges[1].scale + 1e-6);
  }
}

TEST(HorizonCodec, GivenDeviationsAddToTheSpreadOfTheMeans) {
  // Two halves: means 0.1 and 0.3, deviations 0.02 and 0.06. Variance: mean of 0.0004 and 0.0036, and 0.1^2
  // between the halves.
  const auto codec = codec_for(TexelFormat::kRgba16, floats(4), {{"deviations", "given"}});
  Decoded all(*codec, std::vector<float>{0.1F, 0.02F, 0.5F, 0, 0.3F, 0.06F, 0.5F, 0}, 4);
  Decoded mean = mean_of(*codec, all, 4);
  const auto values = values_of<std::uint16_t>(*codec, 0, mean);
  EXPECT_NEAR(values[0], 0.2, 1e-4);
  EXPECT_NEAR(values[1], std::sqrt(0.002 + 0.01), 1e-4);
  EXPECT_NEAR(values[2], 0.5, 1e-4);
  EXPECT_EQ(values[3], 0.0) << "equal angles without deviation have none";
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(3), {{"deviations", "given"}}).find("pair of bands"), std::string::npos);
}

TEST(HorizonCodec, WhatIsNoHorizonLeavesTheTexelWithoutData) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const auto codec = codec_for(TexelFormat::kRgba16, {.type = SampleType::kFloat32, .value_bands = 2, .nodata = -9999.0});
  Decoded row(*codec, std::vector<float>{nan, 0.1F, 0.1F, inf, -9999, 0.1F, 1e30F, 0.1F, 57.0F, 0.1F, 0.2F, 0.1F}, 2);
  EXPECT_FALSE(row.opaque);
  const auto codes = codes_of<std::uint16_t>(*codec, 0, row);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(codes[4 * i], 0) << i;
  EXPECT_NE(codes[4 * 5], 0);
  EXPECT_TRUE(codec->parts()[0].zero_is_nodata);
  EXPECT_EQ(codes[4 * 4 + 2], codes[4 * 5 + 2]) << "its neighbour's other direction";
  EXPECT_NEAR(codes[2], 32768, 1) << "level ground where there is no neighbour";
  Decoded lowest(*codec, std::vector<float>{-1.5707964F, 0.0F}, 2);
  EXPECT_EQ(codes_of<std::uint16_t>(*codec, 0, lowest)[0], 1) << "no angle looks like no data";
  std::array<std::uint16_t, 4> outside{7, 7, 7, 7};
  codec->mark_outside(0, reinterpret_cast<std::byte*>(outside.data()), 1);
  EXPECT_EQ(outside, (std::array<std::uint16_t, 4>{0, 7, 7, 7}));
}

TEST(HorizonCodec, DirectionsArePartsNamedByTheirAzimuths) {
  const auto two = codec_for(TexelFormat::kRgba16, floats(2));
  ASSERT_EQ(two->parts().size(), 1U);
  EXPECT_EQ(two->parts()[0].components, (std::vector<std::string>{"east mean", "east deviation", "west mean", "west deviation"}));
  EXPECT_EQ(two->parts()[0].metadata_json, R"({"azimuths_deg":[90.0,270.0]})");
  EXPECT_EQ(two->parts()[0].unit, "rad");
  const auto blocks = codec_for(TexelFormat::kBc5, floats(2));
  ASSERT_EQ(blocks->parts().size(), 2U);
  EXPECT_EQ(blocks->parts()[1].suffix, "west");

  const auto sixteen = codec_for(TexelFormat::kRgba16, floats(16));
  ASSERT_EQ(sixteen->parts().size(), 8U);
  EXPECT_EQ(sixteen->parts()[1].suffix, "north-east-az067.5");
  EXPECT_EQ(sixteen->parts()[7].components[2], "az337.5 mean");

  const auto three = codec_for(TexelFormat::kRgba8, floats(3), {{"azimuths", "100,180,247.5"}});
  ASSERT_EQ(three->parts().size(), 2U);
  EXPECT_EQ(three->parts()[1].suffix, "az247.5");
  EXPECT_EQ(three->parts()[1].format, TexelFormat::kRg8) << "one direction is left";
  Decoded row(*three, std::vector<float>{0.1F, 0.2F, 0.3F}, 3);
  EXPECT_NEAR(values_of<std::uint8_t>(*three, 0, row)[2], 0.2, 0.51 * three->parts()[0].ranges[0].scale);
  EXPECT_NEAR(values_of<std::uint8_t>(*three, 1, row)[0], 0.3, 0.51 * three->parts()[1].ranges[0].scale);

  const auto most = codec_for(TexelFormat::kBc5, floats(24));
  EXPECT_EQ(most->parts().size(), 24U);
  EXPECT_LE(most->planes(), kMaxPlanes);
  EXPECT_NE(refusal(TexelFormat::kBc5, floats(25)).find("1 to 24 directions"), std::string::npos);
}

TEST(HorizonCodec, TwentyFourDirectionsKeepToThemselves) {
  const auto codec = codec_for(TexelFormat::kRg16, floats(24));
  std::vector<float> samples;
  for (int d = 0; d < 24; ++d) samples.push_back(0.01F * static_cast<float>(d));
  for (int d = 0; d < 24; ++d) samples.push_back(0.03F * static_cast<float>(d));
  Decoded all(*codec, samples, 24);
  Decoded mean = mean_of(*codec, all, 24);
  for (std::size_t part = 0; part < 24; ++part) {
    const auto values = values_of<std::uint16_t>(*codec, part, mean);
    EXPECT_NEAR(values[0], 0.02 * static_cast<double>(part), 5e-5);
    EXPECT_NEAR(values[1], 0.01 * static_cast<double>(part), 5e-5);
  }
}

TEST(HorizonCodec, ANarrowSpanMakesEightBitsShowLowSun) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> angle(0.0F, 25.0F);
  std::vector<float> samples(4000);
  for (float& s : samples) s = angle(random);
  const auto lit_error = [&](TexelFormat format, const std::string& span) {
    const auto codec = codec_for(format, floats(2), {{"angles", "deg"}, {"span", span}});
    Decoded row(*codec, samples, 2);
    std::vector<ErrorSum> errors(2);
    const std::size_t components = codec->parts()[0].components.size();
    std::vector<float> stored;
    if (format_info(format).samples == SampleKind::kUnorm8)
      for (const auto code : codes_of<std::uint8_t>(*codec, 0, row)) stored.push_back(code);
    else
      for (const auto code : codes_of<std::uint16_t>(*codec, 0, row)) stored.push_back(code);
    codec->add_errors(0, row.rows.middle(true).here, stored.data(), row.count, errors);
    EXPECT_EQ(errors[0].count, samples.size() / (components == 2 ? 2 : 1));
    EXPECT_LE(errors[1].largest, 0.51 * codec->parts()[0].ranges[0].scale / kDeg) << span;
    RecordProperty("lit_error_" + std::string(format_info(format).name) + "_" + span, std::to_string(errors[0].mean()));
    return errors[0].mean();
  };
  const double all_in_8 = lit_error(TexelFormat::kRgba8, "-90,90");
  const double low_in_8 = lit_error(TexelFormat::kRgba8, "0,45");
  const double all_in_16 = lit_error(TexelFormat::kRgba16, "-90,90");
  EXPECT_LT(low_in_8, 0.3 * all_in_8) << "steps are a quarter as large";
  EXPECT_LT(all_in_16, 0.01 * all_in_8);
}

TEST(HorizonCodec, RefusesWhatWouldBeWrongAndSaysWhatToUse) {
  for (const TexelFormat format : {TexelFormat::kBc1, TexelFormat::kBc3, TexelFormat::kBc7})
    EXPECT_NE(refusal(format, floats(2)).find("which moves shadows; use rgba16, rg16, rgba8, rg8 or bc5"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kR32Float, floats(2)).find("use rgba16"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(1)).find("`azimuths`"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(2), {{"azimuths", "90"}}).find("1 directions are named"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(2), {{"azimuths", "90,360"}}).find("less than 360"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(2), {{"azimuths", "30,30"}}).find("named twice"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, floats(2), {{"span", "40,10"}}).find("LOW,HIGH"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgba16, {.type = SampleType::kInt16, .value_bands = 2}).find("`angles` deg"), std::string::npos);
  EXPECT_EQ(refusal(TexelFormat::kRgba16, {.type = SampleType::kInt16, .value_bands = 2}, {{"angles", "deg"}}), "");
}

TEST(HorizonCodec, AnglesBeyondTheSpanAndMissingOnesAreCounted) {
  const std::vector<float> samples{5.0F, -11.0F, 61.0F, 60.0F, std::nanf("")};
  const Options options{{"azimuths", "90"}, {"angles", "deg"}, {"span", "-10,60"}};
  for (const TexelFormat format : {TexelFormat::kRg16, TexelFormat::kBc5}) {
    const auto codec = codec_for(format, floats(1), options);
    Decoded row(*codec, samples, 1);
    std::vector<LossCount> counts(codec->losses().size());
    codec->count_losses(row.rows.middle(row.opaque).here, row.opaque, row.count, 0, 0, counts);
    ASSERT_EQ(counts.size(), format == TexelFormat::kBc5 ? 2U : 1U);
    EXPECT_EQ(counts[0].texels, 2U);
    EXPECT_EQ(counts[0].x, 1);
    if (counts.size() == 2) {
      EXPECT_EQ(counts[1].texels, 1U) << "bc5 has no code for no data";
    }
  }
}

}  // namespace
}  // namespace vt::channels
