#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "builder/channels/channel_makers.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

template <class T>
std::vector<float> there_and_back(const SampleLayout& layout, const std::vector<T>& samples) {
  auto codec = make_elevation_codec({.channel = ChannelType::kElevation, .format = TexelFormat::kR32Float}, layout);
  EXPECT_TRUE(codec.has_value());
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = (*codec)->decode_row(bytes_of(samples), count, rows.row(1));
  std::vector<float> texels(samples.size());
  (*codec)->encode_row(0, rows.middle(opaque), count, reinterpret_cast<std::byte*>(texels.data()));
  return texels;
}

TEST(ElevationCodec, HeightsOfEveryTypeComeBack) {
  const auto check = [](SampleType type, auto samples) {
    const auto texels = there_and_back({.type = type, .value_bands = 1}, samples);
    for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(texels[i], static_cast<float>(samples[i])) << sample_name(type);
  };
  check(SampleType::kUint8, std::vector<std::uint8_t>{0, 1, 255});
  check(SampleType::kInt8, std::vector<std::int8_t>{-128, 0, 127});
  check(SampleType::kUint16, std::vector<std::uint16_t>{0, 8848, 65535});
  check(SampleType::kInt16, std::vector<std::int16_t>{-32768, -1, 0, 8848, 32767});
  check(SampleType::kUint32, std::vector<std::uint32_t>{0, 1U << 24});
  check(SampleType::kInt32, std::vector<std::int32_t>{-(1 << 24), 1 << 24});
  check(SampleType::kFloat32, std::vector<float>{-11034.0F, 0.1F, 8848.86F, 3e38F});
  check(SampleType::kFloat64, std::vector<double>{0.5, -0.25});
}

TEST(ElevationCodec, VoidsBecomeNaNWhateverTheyAreCalled) {
  const auto with_int =
      there_and_back({.type = SampleType::kInt16, .value_bands = 1, .nodata = -32768.0}, std::vector<std::int16_t>{-32768, 5});
  EXPECT_TRUE(std::isnan(with_int[0]));
  EXPECT_EQ(with_int[1], 5.0F);
  // As decimal text the lowest float is not exactly the float.
  const auto with_text = there_and_back({.type = SampleType::kFloat32, .value_bands = 1, .nodata = -3.4028234663852886e+38},
                                        std::vector<float>{std::numeric_limits<float>::lowest(), 5.0F});
  EXPECT_TRUE(std::isnan(with_text[0]));
  const auto not_finite =
      there_and_back({.type = SampleType::kFloat32, .value_bands = 1},
                     std::vector<float>{std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1.0F});
  EXPECT_TRUE(std::isnan(not_finite[0]));
  EXPECT_TRUE(std::isnan(not_finite[1]));
  EXPECT_EQ(not_finite[2], 1.0F);
  const auto beyond_type =
      there_and_back({.type = SampleType::kUint8, .value_bands = 1, .nodata = -9999.0}, std::vector<std::uint8_t>{0, 241});
  EXPECT_EQ(beyond_type[0], 0.0F) << "a nodata the type cannot hold equals nothing, in particular not its low bits";
  EXPECT_EQ(beyond_type[1], 241.0F);
}

TEST(ElevationCodec, OutsideIsNaN) {
  const auto codec = make_elevation_codec({.channel = ChannelType::kElevation, .format = TexelFormat::kR32Float}, {.value_bands = 1});
  float texel = 3.0F;
  (*codec)->mark_outside(0, reinterpret_cast<std::byte*>(&texel), 1);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &texel, sizeof bits);
  EXPECT_EQ(bits, 0x7FC00000U) << "the one NaN that the format document names";
}

}  // namespace
}  // namespace vt::channels
