#include "builder/channels/mask/mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "builder/channels/all_channels.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

std::unique_ptr<const ChannelCodec> mask(const SampleLayout& layout, TexelFormat format = TexelFormat::kR8, const Options& options = {}) {
  auto codec = make_codec({.channel = ChannelType::kMask, .format = format, .options = options}, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return std::move(*codec);
}

template <class Code, class Sample>
std::vector<Code> there_and_back(const ChannelCodec& codec, const std::vector<Sample>& samples, std::int64_t count) {
  Rows rows(count);
  const bool opaque = codec.decode_row(bytes_of(samples), count, rows.row(1));
  std::vector<Code> texels(static_cast<std::size_t>(count));
  EXPECT_TRUE(codec.encode_row(0, rows.middle(opaque), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
  return texels;
}

TEST(MaskCodec, SharesOfEveryTypeComeBack) {
  std::vector<std::uint8_t> bytes(256);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  const auto of_bytes = mask({.value_bands = 1});
  EXPECT_EQ(there_and_back<std::uint8_t>(*of_bytes, bytes, 256), bytes);
  EXPECT_TRUE(of_bytes->samples_are_texels());

  std::vector<std::uint16_t> words{0, 1, 32768, 65534, 65535};
  EXPECT_EQ(there_and_back<std::uint16_t>(*mask({.type = SampleType::kUint16, .value_bands = 1}, TexelFormat::kR16), words, 5), words);

  const std::vector<float> floats{-0.5F, 0.0F, 0.5F, 1.0F, 7.0F, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_EQ(there_and_back<std::uint8_t>(*mask({.type = SampleType::kFloat32, .value_bands = 1}), floats, 6),
            (std::vector<std::uint8_t>{0, 0, 128, 255, 255, 0}));
}

TEST(MaskCodec, ListedValuesAreInsideAndAllOthersOutside) {
  const auto codec = mask({.type = SampleType::kInt16, .value_bands = 1, .nodata = -1.0}, TexelFormat::kR8, {{"inside", "3,41,-7"}});
  const std::vector<std::int16_t> classes{3, 4, 41, -7, 0, -1};
  EXPECT_EQ(there_and_back<std::uint8_t>(*codec, classes, 6), (std::vector<std::uint8_t>{255, 0, 255, 255, 0, 0}));
  EXPECT_FALSE(codec->samples_are_texels());
  const auto of_bytes = mask({.value_bands = 1}, TexelFormat::kR8, {{"inside", "2"}});
  EXPECT_EQ(there_and_back<std::uint8_t>(*of_bytes, std::vector<std::uint8_t>{1, 2, 3}, 3), (std::vector<std::uint8_t>{0, 255, 0}));
}

TEST(MaskCodec, TexelsWithoutDataAreCountedBecauseZeroCannotSayIt) {
  const auto codec = mask({.value_bands = 1, .nodata = 9.0});
  Rows rows(4);
  const bool opaque = codec->decode_row(bytes_of(std::vector<std::uint8_t>{0, 9, 255, 9}), 4, rows.row(1));
  std::vector<LossCount> counts(codec->losses().size());
  codec->count_losses(rows.middle(opaque).here, opaque, 4, 10, 2, counts);
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(counts[0].texels, 2U);
  EXPECT_EQ(counts[0].x, 11);
}

TEST(MaskCodec, NodataAndClearTexelsWeighNothing) {
  const auto with_nodata = mask({.value_bands = 1, .nodata = 9.0});
  Rows rows(2);
  EXPECT_FALSE(with_nodata->decode_row(bytes_of(std::vector<std::uint8_t>{9, 255}), 2, rows.row(1)));
  EXPECT_EQ(rows.row(1)[1][0], 0.0F);
  EXPECT_EQ(rows.row(1)[1][1], 1.0F);
  const auto with_alpha = mask({.value_bands = 1, .has_alpha = true});
  EXPECT_FALSE(with_alpha->decode_row(bytes_of(std::vector<std::uint8_t>{200, 0, 200, 255}), 2, rows.row(1)));
  EXPECT_EQ(rows.row(1)[0][0], 0.0F);
  EXPECT_EQ(rows.row(1)[1][0], 0.0F);
  EXPECT_EQ(rows.row(1)[1][1], 1.0F);
}

TEST(MaskCodec, RoundingIsWithoutBias) {
  const auto codec = mask({.value_bands = 1});
  constexpr std::int64_t kCount = 255 * 4;
  Rows rows(kCount);
  double wanted = 0.0;
  for (std::int64_t i = 0; i < kCount; ++i) {
    rows.row(1)[0][i] = 0.25F * static_cast<float>(i);  // what means of four bytes can be
    rows.row(1)[1][i] = 1.0F;
    wanted += 0.25 * static_cast<double>(i);
  }
  std::vector<std::uint8_t> texels(kCount);
  ASSERT_TRUE(codec->encode_row(0, rows.middle(true), kCount, reinterpret_cast<std::byte*>(texels.data())).has_value());
  double sum = 0.0;
  for (const std::uint8_t texel : texels) sum += texel;
  EXPECT_NEAR(sum / kCount, wanted / kCount, 0.001);
}

TEST(MaskCodec, ReachesSixteenBitsOnTheWayToBlocks) {
  const auto codec = mask({.value_bands = 1}, TexelFormat::kBc4);
  EXPECT_EQ(codec->parts()[0].texel_format, TexelFormat::kR16);
  EXPECT_EQ(codec->parts()[0].ranges[0].scale, 1.0 / 255.0) << "bc4 decodes to 0 to 255";
  EXPECT_EQ(there_and_back<std::uint16_t>(*codec, std::vector<std::uint8_t>{0, 1, 255}, 3), (std::vector<std::uint16_t>{0, 257, 65535}));
}

TEST(MaskCodec, AlphaTestsKeepThePlainMeanBeside) {
  const auto codec = mask({.value_bands = 1}, TexelFormat::kR8, {{"alpha-coverage", "0.5"}});
  ASSERT_EQ(codec->parts().size(), 2U);
  EXPECT_EQ(codec->kept_above(), 0.5);
  EXPECT_TRUE(codec->parts()[0].ends_at_base);
  EXPECT_TRUE(codec->parts()[1].starts_above_base);
}

TEST(MaskCodec, RefusesWhatItCannotMean) {
  const auto refused = [](TexelFormat format, const SampleLayout& layout, const Options& options) {
    const auto codec = make_codec({.channel = ChannelType::kMask, .format = format, .options = options}, layout);
    EXPECT_FALSE(codec.has_value());
    return codec ? std::string() : codec.error().message;
  };
  EXPECT_NE(refused(TexelFormat::kRgb8, {.value_bands = 1}, {}).find("bc4"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR8, {.value_bands = 3}, {}).find("`bands`"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR8, {.type = SampleType::kInt16, .value_bands = 1}, {}).find("`inside`"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR8, {.value_bands = 1}, {{"inside", ""}}).find("inside"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR8, {.value_bands = 1}, {{"alpha-coverage", "1"}}).find("alpha-coverage"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR8, {.value_bands = 1, .range = std::array<double, 2>{0, 9}}, {{"inside", "1"}}).find("exclude"),
            std::string::npos);
}

}  // namespace
}  // namespace vt::channels
