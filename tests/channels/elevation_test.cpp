#include "builder/channels/elevation/elevation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "builder/channels/all_channels.h"
#include "store/texel/texel_decoder.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

template <class T>
std::vector<float> there_and_back(const SampleLayout& layout, const std::vector<T>& samples) {
  auto codec = make_codec({.channel = ChannelType::kElevation, .format = TexelFormat::kR32Float}, layout);
  EXPECT_TRUE(codec.has_value());
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = (*codec)->decode_row(bytes_of(samples), count, rows.row(1));
  std::vector<float> texels(samples.size());
  EXPECT_TRUE((*codec)->encode_row(0, rows.middle(opaque), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
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
  // However many digits people type of the lowest float.
  for (const double typed : {-3.4e38, -3.40282e38, -3.4028235e38, -3.40282347e38}) {
    const auto lowest = there_and_back({.type = SampleType::kFloat32, .value_bands = 1, .nodata = typed},
                                       std::vector<float>{std::numeric_limits<float>::lowest(), -1e37F, 5.0F});
    EXPECT_TRUE(std::isnan(lowest[0])) << typed;
    EXPECT_EQ(lowest[1], -1e37F) << "absurd, but a height";
    EXPECT_EQ(lowest[2], 5.0F);
  }
  const auto tenth =
      there_and_back({.type = SampleType::kFloat32, .value_bands = 1, .nodata = -9999.9}, std::vector<float>{-9999.9F, 5.0F});
  EXPECT_TRUE(std::isnan(tenth[0])) << "the float nearest to what was typed";
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
  const auto between =
      there_and_back({.type = SampleType::kInt16, .value_bands = 1, .nodata = -9999.4}, std::vector<std::int16_t>{-9999, -10000});
  EXPECT_TRUE(std::isnan(between[0])) << "the fraction is dropped";
  EXPECT_EQ(between[1], -10000.0F);
}

TEST(ElevationCodec, OutsideIsNaN) {
  const auto codec = make_codec({.channel = ChannelType::kElevation, .format = TexelFormat::kR32Float}, {.value_bands = 1});
  float texel = 3.0F;
  (*codec)->mark_outside(0, reinterpret_cast<std::byte*>(&texel), 1);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &texel, sizeof bits);
  EXPECT_EQ(bits, 0x7FC00000U) << "the one NaN that the format document names";
}

std::unique_ptr<const ChannelCodec> heights(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  auto codec = make_codec({.channel = ChannelType::kElevation, .format = format, .options = options}, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return std::move(*codec);
}

// The heights that `T` texels of part 0 stand for after decoding and encoding `samples`.
template <class T, class Sample>
std::vector<T> encoded(const ChannelCodec& codec, const std::vector<Sample>& samples) {
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = codec.decode_row(bytes_of(samples), count, rows.row(1));
  std::vector<T> texels(samples.size());
  EXPECT_TRUE(codec.encode_row(0, rows.middle(opaque), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
  return texels;
}

TEST(ElevationCodec, SixteenBitIntegersFitTheirOwnCodes) {
  const auto codec = heights(TexelFormat::kR16, {.type = SampleType::kInt16, .value_bands = 1, .nodata = -32768.0});
  const ComponentRange range = codec->parts()[0].ranges[0];
  EXPECT_EQ(range.scale, 1.0);
  EXPECT_TRUE(codec->parts()[0].zero_is_nodata);
  const std::vector<std::int16_t> samples{-32768, -32767, -1, 0, 1, 8848, 32767};
  const auto codes = encoded<std::uint16_t>(*codec, samples);
  EXPECT_EQ(codes[0], 0);
  for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_EQ(range.offset + range.scale * codes[i], samples[i]);
}

TEST(ElevationCodec, TheQuantumIsTheFinestPowerOfTwoThatHoldsTheRange) {
  const auto quantum = [](double low, double high) {
    const auto codec =
        heights(TexelFormat::kR16, {.type = SampleType::kFloat32, .value_bands = 1, .range = std::array<double, 2>{low, high}});
    const ComponentRange range = codec->parts()[0].ranges[0];
    EXPECT_LE(range.offset + range.scale, low);
    EXPECT_GE(range.offset + range.scale * 65535.0, high);
    EXPECT_EQ(std::exp2(std::round(std::log2(range.scale))), range.scale);
    // Half of it would not do.
    EXPECT_GT(std::ceil(high / (range.scale / 2)) - std::floor(low / (range.scale / 2)), 65534.0);
    return range.scale;
  };
  EXPECT_EQ(quantum(0.0, 1000.0), 1.0 / 64);
  EXPECT_EQ(quantum(-500.0, 1500.0), 1.0 / 32);
  EXPECT_EQ(quantum(0.0, 65534.0), 1.0);
  EXPECT_EQ(quantum(0.0, 65534.5), 2.0);
  EXPECT_EQ(quantum(-11034.0, 8848.0), 0.5);
}

TEST(ElevationCodec, HalvesAndCodesOfBoundsEncloseWhatTheyBound) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> anywhere(-9000.0F, 9000.0F);
  for (const TexelFormat format : {TexelFormat::kR16Float, TexelFormat::kR16, TexelFormat::kR32Float})
    for (const char* quantum : {"0.3", "0.5"}) {
      SampleLayout layout{.type = SampleType::kFloat32, .value_bands = 1};
      Options options{{"bounds", "yes"}};
      if (format == TexelFormat::kR16) {
        layout.range = std::array<double, 2>{-9000.0, 9000.0};
        options["quantum"] = quantum;
      }
      const auto codec = heights(format, layout, options);
      ASSERT_EQ(codec->parts().size(), 2U);
      const Part& bounds = codec->parts()[1];
      constexpr std::int64_t kCount = 5000;
      std::vector<float> samples(kCount);
      for (float& sample : samples) sample = anywhere(random);
      samples[0] = 0.0F;
      samples[1] = -0.0F;
      samples[2] = 1e-9F;
      samples[3] = -1e-9F;
      samples[4] = 2048.0F;
      samples[5] = -2049.0F;
      Rows rows(kCount);
      codec->decode_row(bytes_of(samples), kCount, rows.row(1));
      codec->derive_row(kCount, rows.row(1));
      std::vector<std::byte> texels(kCount * format_info(bounds.format).block_bytes);
      ASSERT_TRUE(codec->encode_row(1, rows.middle(true), kCount, texels.data()).has_value());
      std::vector<float> stored(2 * kCount);
      store::decode_texels(bounds.format, texels, kCount, 1, stored);
      for (std::size_t i = 0; i < kCount; ++i) {
        const double low = bounds.ranges[0].offset + bounds.ranges[0].scale * static_cast<double>(stored[2 * i]);
        const double high = bounds.ranges[1].offset + bounds.ranges[1].scale * static_cast<double>(stored[2 * i + 1]);
        ASSERT_LE(low, static_cast<double>(samples[i]));
        ASSERT_GE(high, static_cast<double>(samples[i]));
        const double step = format == TexelFormat::kR16 ? bounds.ranges[0].scale : format == TexelFormat::kR16Float ? 8.0 : 0.0;
        ASSERT_LE(high - low, step + 1e-11) << samples[i] << ": four roundings to doubles around 9000";
      }
    }
}

std::unique_ptr<const ChannelCodec> wide_heights(TexelFormat format, const SampleLayout& layout, const Options& options) {
  auto codec = make_codec({.channel = ChannelType::kElevation, .format = format, .samples_are_wide = true, .options = options}, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return std::move(*codec);
}

// Heights that no float can hold: `codec` was made for them.
template <class Sample>
void expect_wide_heights_are_held(const ChannelCodec& codec, const std::vector<Sample>& samples, double half_step) {
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  ASSERT_TRUE(codec.decode_row(bytes_of(samples), count, rows.row(1)));
  codec.derive_row(count, rows.row(1));
  for (std::size_t part = 0; part < 2; ++part) {
    const Part& info = codec.parts()[part];
    std::vector<std::byte> texels(samples.size() * format_info(info.format).block_bytes);
    const auto done = codec.encode_row(part, rows.middle(true), count, texels.data());
    ASSERT_TRUE(done.has_value()) << done.error().message;
    std::vector<float> stored(samples.size() * (part + 1));
    store::decode_texels(info.format, texels, samples.size(), 1, stored);
    const auto value = [&](std::size_t i) { return info.ranges[0].offset + info.ranges[0].scale * static_cast<double>(stored[i]); };
    if (part == 0) {
      // As stored, in double: the truth that is reported.
      double largest = 0.0;
      for (std::size_t i = 0; i < samples.size(); ++i) {
        EXPECT_NEAR(value(i), static_cast<double>(samples[i]), half_step);
        largest = std::max(largest, std::abs(value(i) - static_cast<double>(samples[i])));
      }
      std::vector<ErrorSum> errors(1);
      codec.add_errors(0, rows.middle(true).here, stored.data(), count, errors);
      EXPECT_NEAR(errors[0].largest, largest, 1e-14 * std::abs(static_cast<double>(samples[0]))) << "48 bits of planes";
      continue;
    }
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_LE(value(2 * i), static_cast<double>(samples[i]));
      EXPECT_GE(value(2 * i + 1), static_cast<double>(samples[i]));
      EXPECT_LE(value(2 * i + 1) - value(2 * i), 4.0 * half_step + 1e-11) << "no wider than two steps: of the planes, of what is stored";
    }
  }
}

TEST(ElevationCodec, HeightsThatNoFloatIsAreBoundedOutwardAndMeasuredAgainst) {
  std::mt19937 random(14);
  std::uniform_real_distribution<double> relief(0.0, 50.0);
  const Options bounds{{"bounds", "yes"}};
  const auto doubles = [&](double base) {
    std::vector<double> samples(4000);
    for (double& sample : samples) sample = base + relief(random);
    return samples;
  };
  const SampleLayout f64{.type = SampleType::kFloat64, .value_bands = 1};
  const auto in_range = [&](double low, double high) {
    return SampleLayout{.type = SampleType::kFloat64, .value_bands = 1, .range = std::array<double, 2>{low, high}};
  };
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR32Float, f64, bounds), doubles(8000.0), 0x1p-12);
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR16Float, f64, bounds), doubles(8000.0), 2.0);
  // 200 m in 65534 steps: 2^-8 m. 10 km: 2^-2 m.
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR16, in_range(7900, 8100), bounds), doubles(8000.0), 0x1p-9);
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR16, in_range(6370000, 6380000), bounds), doubles(6.37e6), 0x1p-3);
  // Millimetres about a million.
  std::vector<double> waves;
  for (int i = 0; i < 2000; ++i) waves.push_back(1e6 + 1e-3 * std::sin(i / 3.0) + 1e-3 * std::cos(i / 4.0));
  const double step = 0x1p-16;
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR16, in_range(999999.99, 1000000.01), bounds), waves, 0.5 * step + 4e-9);

  std::vector<std::int32_t> integers(4000);
  for (std::int32_t& sample : integers) sample = 2147483647 - static_cast<std::int32_t>(random() % 100000);
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR32Float, {.type = SampleType::kInt32, .value_bands = 1}, bounds), integers,
                               64.0);
  std::vector<std::uint32_t> large(4000);
  for (std::uint32_t& sample : large) sample = 4294967295U - random() % 100000;
  expect_wide_heights_are_held(*wide_heights(TexelFormat::kR32Float, {.type = SampleType::kUint32, .value_bands = 1}, bounds), large,
                               128.0);
}

TEST(ElevationCodec, RoundingIsWithoutBias) {
  // Means of two and four whole metres end in quarters; ties must not all go up.
  const auto codec =
      heights(TexelFormat::kR16, {.type = SampleType::kFloat32, .value_bands = 1, .range = std::array<double, 2>{0.0, 60000.0}});
  ASSERT_EQ(codec->parts()[0].ranges[0].scale, 1.0);
  std::vector<float> samples;
  for (int i = 0; i < 40000; ++i) samples.push_back(100.0F + 0.25F * static_cast<float>(i));
  const auto codes = encoded<std::uint16_t>(*codec, samples);
  double bias = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    bias += codec->parts()[0].ranges[0].offset + static_cast<double>(codes[i]) - static_cast<double>(samples[i]);
  EXPECT_NEAR(bias / 40000.0, 0.0, 1e-4);
}

TEST(ElevationCodec, NamesTheHeightThatDoesNotFit) {
  const auto message = [](TexelFormat format, const SampleLayout& layout, float height) {
    const auto codec = heights(format, layout);
    const std::vector<float> samples{1.0F, height, 2.0F};
    Rows rows(3);
    const bool opaque = codec->decode_row(bytes_of(samples), 3, rows.row(1));
    std::array<std::byte, 12> texels{};
    const auto done = codec->encode_row(0, rows.middle(opaque), 3, texels.data());
    EXPECT_FALSE(done.has_value());
    return done ? std::string() : done.error().message;
  };
  const SampleLayout coded{.type = SampleType::kFloat32, .value_bands = 1, .range = std::array<double, 2>{0.0, 10.0}};
  EXPECT_NE(message(TexelFormat::kR16, coded, -20.25F).find("height -20.25 m"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kR16, coded, 1e30F).find("`range`"), std::string::npos);
  EXPECT_NE(message(TexelFormat::kR16Float, {.type = SampleType::kFloat32, .value_bands = 1}, 70000.0F).find("r16f"), std::string::npos);
}

TEST(ElevationCodec, RefusesWhatItCannotMean) {
  const auto refused = [](TexelFormat format, const SampleLayout& layout, const Options& options) {
    const auto codec = make_codec({.channel = ChannelType::kElevation, .format = format, .options = options}, layout);
    EXPECT_FALSE(codec.has_value());
    return codec ? std::string() : codec.error().message;
  };
  const SampleLayout floats{.type = SampleType::kFloat32, .value_bands = 1};
  EXPECT_NE(refused(TexelFormat::kBc4, floats, {}).find("r16"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR16, floats, {}).find("`range`"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR32Float, floats, {{"quantum", "1"}}).find("r16"), std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR16, {.type = SampleType::kInt16, .value_bands = 1}, {{"quantum", "0.5"}}).find("65535"),
            std::string::npos);
  EXPECT_NE(refused(TexelFormat::kR32Float, floats, {{"fill", "deep"}}).find("fill"), std::string::npos);
}

}  // namespace
}  // namespace vt::channels
