#include <gtest/gtest.h>

#include <random>

#include "builder/channels/channel_makers.h"
#include "builder/channels/srgb.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

ChannelSettings settings_for(TexelFormat format) { return {.format = format, .transfer = Transfer::kSrgb}; }

std::unique_ptr<const ChannelCodec> color(const SampleLayout& layout, TexelFormat format) {
  auto codec = make_color_codec(settings_for(format), layout);
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
  EXPECT_EQ(texels[6], 128);  // 127.5 rounds up
  EXPECT_EQ(texels[9], 255);
  EXPECT_EQ(texels[12], 255);
  EXPECT_EQ(rows.row(1)[3][5], 0.0F) << "NaN is no data";
}

TEST(ColorCodec, RefusesWhatItCannotMean) {
  EXPECT_EQ(make_color_codec(settings_for(TexelFormat::kR32Float), {}).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(make_color_codec(settings_for(TexelFormat::kRgb8), {.value_bands = 2}).error().code, ErrorCode::kUnsupported);
  const auto without_range = make_color_codec(settings_for(TexelFormat::kRgb8), {.type = SampleType::kInt16});
  ASSERT_FALSE(without_range.has_value());
  EXPECT_NE(without_range.error().message.find("--range"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
