#include "builder/channels/color/color.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "builder/channels/all_channels.h"
#include "builder/channels/shared/srgb.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

ChannelSettings settings_for(TexelFormat format) { return {.format = format, .transfer = Transfer::kSrgb}; }

std::unique_ptr<const ChannelCodec> color(const SampleLayout& layout, TexelFormat format) {
  auto codec = make_codec(settings_for(format), layout);
  EXPECT_TRUE(codec.has_value()) << codec.error().message;
  return std::move(*codec);
}

TEST(ColorCodec, OpaqueCodesComeBackExactly) {
  const auto codec = color({}, TexelFormat::kRgb8);
  std::vector<std::uint8_t> samples;
  for (int c = 0; c < 256; ++c)
    for (int k : {0, 85, 170}) samples.push_back(static_cast<std::uint8_t>(c + k));
  Rows rows(256);
  EXPECT_TRUE(codec->decode_row(bytes_of(samples), 256, rows.row(1)));
  std::vector<std::uint8_t> texels(samples.size());
  ASSERT_TRUE(codec->encode_row(0, rows.middle(true), 256, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels, samples);
  EXPECT_TRUE(codec->samples_are_texels());
}

TEST(ColorCodec, TranslucentCodesComeBackExactlyWhereTheyCanBeSeen) {
  const auto codec = color({.has_alpha = true}, TexelFormat::kRgba8);
  std::vector<std::uint8_t> samples;
  for (int alpha = 1; alpha < 256; ++alpha)
    for (int c : {alpha, 255 - alpha, 128}) {
      samples.push_back(static_cast<std::uint8_t>(c));
      if (samples.size() % 4 == 3) samples.push_back(static_cast<std::uint8_t>(alpha));
    }
  const auto count = static_cast<std::int64_t>(samples.size() / 4);
  Rows rows(count);
  EXPECT_FALSE(codec->decode_row(bytes_of(samples), count, rows.row(1)));
  std::vector<std::uint8_t> texels(samples.size());
  ASSERT_TRUE(codec->encode_row(0, rows.middle(false), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels, samples);
}

TEST(ColorCodec, NodataHasNoWeightAndIsGivenBack) {
  const auto codec = color({.nodata = 7.0}, TexelFormat::kRgb8);
  const std::vector<std::uint8_t> samples = {7, 7, 7, 7, 7, 8, 200, 7, 7};
  Rows rows(3);
  EXPECT_FALSE(codec->decode_row(bytes_of(samples), 3, rows.row(1)));
  EXPECT_EQ(rows.row(1)[3][0], 0.0F);
  EXPECT_EQ(rows.row(1)[0][0], 0.0F);
  EXPECT_EQ(rows.row(1)[3][1], 1.0F) << "one band of three is not enough";
  std::vector<std::uint8_t> texels(9);
  ASSERT_TRUE(codec->encode_row(0, rows.middle(false), 3, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels, samples);
}

TEST(ColorCodec, EmptyTexelsBorrowTheColourOfTheirNeighbours) {
  const auto codec = color({.has_alpha = true}, TexelFormat::kRgba8);
  const std::vector<std::uint8_t> samples = {200, 100, 50, 255, 0, 0, 0, 0, 0, 0, 0, 0};
  Rows rows(3);
  codec->decode_row(bytes_of(samples), 3, rows.row(1));
  std::vector<std::uint8_t> texels(12);
  ASSERT_TRUE(codec->encode_row(0, rows.middle(false), 3, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels, (std::vector<std::uint8_t>{200, 100, 50, 255, 200, 100, 50, 0, 0, 0, 0, 0}));
}

TEST(ColorCodec, SixteenBitCodesFollowTheSameCurve) {
  const auto codec = color({.type = SampleType::kUint16}, TexelFormat::kRgb8);
  std::vector<std::uint16_t> samples;
  std::vector<std::uint8_t> wanted;
  for (int c = 0; c < 256; ++c)
    for (int k = 0; k < 3; ++k) {
      samples.push_back(static_cast<std::uint16_t>(c * 257));
      wanted.push_back(static_cast<std::uint8_t>(c));
    }
  Rows rows(256);
  EXPECT_TRUE(codec->decode_row(bytes_of(samples), 256, rows.row(1)));
  std::vector<std::uint8_t> texels(samples.size());
  ASSERT_TRUE(codec->encode_row(0, rows.middle(true), 256, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels, wanted);
}

TEST(ColorCodec, RangeSaysWhatIsBlackAndWhite) {
  const auto codec =
      color({.type = SampleType::kFloat32, .value_bands = 1, .range = std::array<double, 2>{100.0, 200.0}}, TexelFormat::kRgb8);
  const std::vector<float> samples = {50.0F, 100.0F, 150.0F, 200.0F, 300.0F, std::numeric_limits<float>::quiet_NaN()};
  Rows rows(6);
  EXPECT_FALSE(codec->decode_row(bytes_of(samples), 6, rows.row(1)));
  std::vector<std::uint8_t> texels(18);
  ASSERT_TRUE(codec->encode_row(0, rows.middle(false), 6, reinterpret_cast<std::byte*>(texels.data())).has_value());
  EXPECT_EQ(texels[0], 0);
  EXPECT_EQ(texels[3], 0);
  EXPECT_EQ(texels[6], 127);  // half way between 127 and 128 as a code, but nearer to 127 as light
  EXPECT_EQ(texels[9], 255);
  EXPECT_EQ(texels[12], 255);
  EXPECT_EQ(rows.row(1)[3][5], 0.0F) << "NaN is no data";
}

std::unique_ptr<const ChannelCodec> color_with(const Options& options, const SampleLayout& layout, TexelFormat format) {
  ChannelSettings settings = settings_for(format);
  settings.options = options;
  auto codec = make_codec(settings, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return std::move(*codec);
}

TEST(ColorCodec, AssociatedCodesAreDividedByTheirCoverage) {
  const auto codec = color_with({{"alpha", "associated"}}, {.has_alpha = true}, TexelFormat::kRgba8);
  EXPECT_FALSE(codec->samples_are_texels());
  // Straight codes 0 to 255, multiplied by every coverage and rounded as a painting program would.
  std::vector<std::uint8_t> samples;
  std::vector<int> straight;
  for (int alpha = 1; alpha < 256; ++alpha)
    for (int code = 0; code < 256; code += 15) {
      for (int c = 0; c < 3; ++c) samples.push_back(static_cast<std::uint8_t>((code * alpha * 2 + 255) / 510));
      samples.push_back(static_cast<std::uint8_t>(alpha));
      straight.push_back(code);
    }
  const auto count = static_cast<std::int64_t>(straight.size());
  Rows rows(count);
  codec->decode_row(bytes_of(samples), count, rows.row(1));
  std::vector<std::uint8_t> texels(samples.size());
  ASSERT_TRUE(codec->encode_row(0, rows.middle(false), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
  for (std::size_t i = 0; i < straight.size(); ++i) {
    const int alpha = samples[4 * i + 3];
    EXPECT_EQ(texels[4 * i + 3], alpha);
    // Half a code was rounded away, which the division makes larger; half another when the result is rounded.
    EXPECT_LE(std::abs(texels[4 * i] - straight[i]), 0.5 * 255.0 / alpha + 0.5) << "code " << straight[i] << " at coverage " << alpha;
  }
}

TEST(ColorCodec, AssociatedCodesBeyondTheirCoverageDoNotExplode) {
  const auto codec = color_with({{"alpha", "associated"}}, {.has_alpha = true}, TexelFormat::kRgba8);
  const std::vector<std::uint8_t> samples{255, 255, 255, 1, 90, 3, 200, 2, 7, 7, 7, 0};
  Rows rows(3);
  codec->decode_row(bytes_of(samples), 3, rows.row(1));
  for (std::size_t p = 0; p < 3; ++p)
    for (std::int64_t i = 0; i < 3; ++i) EXPECT_LE(rows.row(1)[p][i], rows.row(1)[3][i]) << "no more light than white of that coverage";
  EXPECT_EQ(rows.row(1)[0][2], 0.0F) << "what is clear has no colour, whatever its codes";
}

TEST(ColorCodec, LinearInputIsEncodedAsSrgb) {
  const auto codec = color_with({{"transfer", "linear"}}, {}, TexelFormat::kRgb8);
  EXPECT_FALSE(codec->samples_are_texels());
  std::vector<std::uint8_t> samples;
  for (int c = 0; c < 256; ++c)
    for (int k = 0; k < 3; ++k) samples.push_back(static_cast<std::uint8_t>(c));
  Rows rows(256);
  EXPECT_TRUE(codec->decode_row(bytes_of(samples), 256, rows.row(1)));
  std::vector<std::uint8_t> texels(samples.size());
  ASSERT_TRUE(codec->encode_row(0, rows.middle(true), 256, reinterpret_cast<std::byte*>(texels.data())).has_value());
  for (int c = 0; c < 256; ++c) {
    int wanted = 0;
    for (int code = 1; code < 256; ++code)
      if (std::abs(linear_from_srgb(code / 255.0) - c / 255.0) < std::abs(linear_from_srgb(wanted / 255.0) - c / 255.0)) wanted = code;
    EXPECT_EQ(texels[static_cast<std::size_t>(3 * c)], wanted) << "light " << c << " / 255";
  }
}

TEST(ColorCodec, ErrorsOfCoverageAreMeasuredWhereItIsStored) {
  for (const TexelFormat format : {TexelFormat::kRgba8, TexelFormat::kBc3, TexelFormat::kBc7}) {
    const auto codec = color({.has_alpha = true}, format);
    ASSERT_EQ(codec->measures().size(), 2U);
    EXPECT_EQ(codec->measures()[1].name, "coverage");
    const std::vector<std::uint8_t> samples{10, 20, 30, 255, 10, 20, 30, 51, 10, 20, 30, 0};
    Rows rows(3);
    codec->decode_row(bytes_of(samples), 3, rows.row(1));
    const std::vector<float> stored{10, 20, 30, 245, 10, 20, 30, 71, 99, 99, 99, 5};
    std::vector<ErrorSum> errors(2);
    codec->add_errors(0, rows.middle(false).here, stored.data(), 3, errors);
    EXPECT_EQ(errors[1].count, 3U) << "what is clear has a coverage too";
    EXPECT_NEAR(errors[1].largest, 20.0 / 255, 1e-7);
    EXPECT_NEAR(errors[1].sum, 35.0 / 255, 1e-7);
    EXPECT_NEAR(errors[1].stored_total / errors[1].reference_total, 321.0 / 306, 1e-7);
  }
  EXPECT_EQ(color({.has_alpha = true}, TexelFormat::kBc1)->measures().size(), 1U);
}

// The coarser levels of a strip one texel wide are covered by a quarter, a sixteenth and so on.
TEST(ColorCodec, ErrorsOfLightAreMeasuredHoweverLittleIsCovered) {
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kBc1, TexelFormat::kRgba8}) {
    const auto codec = color({}, format);
    const double light = linear_from_srgb(100 / 255.0);
    for (const float weight : {1.0F, 0.25F, 1.0F / 64}) {
      Rows rows(1);
      for (std::size_t p = 0; p < 3; ++p) rows.row(1)[p][0] = weight * static_cast<float>(light);
      rows.row(1)[3][0] = weight;
      const std::vector<float> stored{100, 102, 100, std::round(255.0F * weight)};
      std::vector<ErrorSum> errors(codec->measures().size());
      codec->add_errors(0, rows.middle(false).here, stored.data(), 1, errors);
      EXPECT_EQ(errors[0].count, 3U) << format_info(format).name << " " << weight;
      const double seen = format == TexelFormat::kRgba8 ? static_cast<double>(weight) : 1.0;
      EXPECT_NEAR(errors[0].largest, seen * (linear_from_srgb(102 / 255.0) - light), 1e-7);
    }
  }
}

TEST(ColorCodec, OpaqueFormatsSayWhatTheyShowWhereThereAreNoData) {
  const auto counted = [](const SampleLayout& layout, TexelFormat format, const std::vector<std::uint8_t>& samples) {
    const auto codec = color(layout, format);
    const std::int64_t count = 3;
    Rows rows(count);
    const bool opaque = codec->decode_row(bytes_of(samples), count, rows.row(1));
    std::vector<LossCount> counts(codec->losses().size());
    codec->count_losses(rows.middle(opaque).here, opaque, count, 40, 7, counts);
    return std::pair(codec->losses().empty() ? std::string() : codec->losses()[0].what, counts);
  };
  const std::vector<std::uint8_t> translucent{1, 2, 3, 255, 1, 2, 3, 0, 1, 2, 3, 1};
  const auto [what, counts] = counted({.has_alpha = true}, TexelFormat::kRgb8, translucent);
  EXPECT_NE(what.find("rgb8 cannot say: it shows the neighbours' colour, or black where they have none"), std::string::npos) << what;
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(counts[0].texels, 1U) << "what is hardly covered has a colour";
  EXPECT_EQ(counts[0].x, 41);
  EXPECT_EQ(counts[0].y, 7);
  const std::vector<std::uint8_t> holes{9, 9, 9, 1, 2, 3, 9, 9, 9};
  const auto [code, holes_counted] = counted({.nodata = 9.0}, TexelFormat::kBc1, holes);
  EXPECT_NE(code.find("the sources' own code 9; to keep them apart use bc3 or bc7"), std::string::npos) << code;
  EXPECT_EQ(holes_counted[0].texels, 2U);
  EXPECT_TRUE(counted({.has_alpha = true}, TexelFormat::kRgba8, translucent).second.empty());
}

TEST(ColorCodec, CoverageThatIsNoNumberIsNone) {
  const auto codec =
      color({.type = SampleType::kFloat32, .has_alpha = true, .range = std::array<double, 2>{0.0, 1.0}}, TexelFormat::kRgba8);
  const std::vector<float> samples{0.5F, 0.5F, 0.5F, std::numeric_limits<float>::quiet_NaN()};
  Rows rows(1);
  EXPECT_FALSE(codec->decode_row(bytes_of(samples), 1, rows.row(1)));
  for (std::size_t p = 0; p < 4; ++p) EXPECT_EQ(rows.row(1)[p][0], 0.0F);
}

TEST(ColorCodec, AssociatedNeedsACoverageBand) {
  ChannelSettings settings = settings_for(TexelFormat::kRgb8);
  settings.options = {{"alpha", "associated"}};
  EXPECT_EQ(make_codec(settings, {}).error().code, ErrorCode::kUsage);
  const auto with_range = make_codec(settings, {.type = SampleType::kFloat32, .has_alpha = true, .range = std::array<double, 2>{1.0, 2.0}});
  ASSERT_FALSE(with_range.has_value());
  EXPECT_NE(with_range.error().message.find("`range` 0,HIGH"), std::string::npos);
}

TEST(ColorCodec, RefusesWhatItCannotMean) {
  EXPECT_EQ(make_codec(settings_for(TexelFormat::kR32Float), {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(make_codec(settings_for(TexelFormat::kRgb8), {.value_bands = 2}).error().code, ErrorCode::kUnsupported);
  const auto without_range = make_codec(settings_for(TexelFormat::kRgb8), {.type = SampleType::kInt16});
  ASSERT_FALSE(without_range.has_value());
  EXPECT_NE(without_range.error().message.find("`range`"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
