#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <span>

#include "builder/channels/all_channels.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

ChannelSettings settings_of(TexelFormat format, Options options = {}, double source_nodata = std::nan("")) {
  return {.channel = ChannelType::kMaterial, .format = format, .source_nodata = source_nodata, .options = std::move(options)};
}

std::unique_ptr<const ChannelCodec> codec_of(const ChannelSettings& settings, const SampleLayout& layout) {
  auto codec = make_codec(settings, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return codec ? std::move(*codec) : nullptr;
}

std::string refusal_of(const ChannelSettings& settings, const SampleLayout& layout = {.value_bands = 1}) {
  const auto codec = make_codec(settings, layout);
  return codec ? "" : codec.error().message;
}

template <class Code, class T>
std::vector<int> there_and_back(const ChannelSettings& settings, const SampleLayout& layout, const std::vector<T>& samples) {
  const auto codec = codec_of(settings, layout);
  const auto count = static_cast<std::int64_t>(samples.size());
  Rows rows(count);
  const bool opaque = codec->decode_row(bytes_of(samples), count, rows.row(1));
  codec->derive_row(count, rows.row(1));
  std::vector<Code> texels(samples.size());
  EXPECT_TRUE(codec->encode_row(0, rows.middle(opaque), count, reinterpret_cast<std::byte*>(texels.data())).has_value());
  if (codec->samples_are_texels()) {
    EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(samples)), std::as_bytes(std::span(texels))));
  }
  return {texels.begin(), texels.end()};
}

TEST(MaterialCodec, ClassesOfEveryTypeComeBack) {
  using Codes = std::vector<int>;
  const auto r8 = settings_of(TexelFormat::kR8);
  const auto r16 = settings_of(TexelFormat::kR16);
  EXPECT_EQ((there_and_back<std::uint8_t>(r8, {.value_bands = 1}, std::vector<std::uint8_t>{0, 1, 254})), (Codes{0, 1, 254}));
  EXPECT_EQ((there_and_back<std::uint8_t>(r8, {.type = SampleType::kInt16, .value_bands = 1}, std::vector<std::int16_t>{0, 1, 254})),
            (Codes{0, 1, 254}));
  EXPECT_EQ(
      (there_and_back<std::uint16_t>(r16, {.type = SampleType::kUint16, .value_bands = 1}, std::vector<std::uint16_t>{0, 300, 65534})),
      (Codes{0, 300, 65534}));
  EXPECT_EQ((there_and_back<std::uint16_t>(r16, {.type = SampleType::kInt32, .value_bands = 1}, std::vector<std::int32_t>{7, 65534})),
            (Codes{7, 65534}));
}

TEST(MaterialCodec, NoDataHasACodeOfItsOwn) {
  using Codes = std::vector<int>;
  const std::vector<std::uint8_t> samples{0, 3, 128};
  // Declared, it stays what it is; otherwise the greatest code is kept for it.
  EXPECT_EQ((there_and_back<std::uint8_t>(settings_of(TexelFormat::kR8, {}, 0.0), {.value_bands = 1, .nodata = 0.0}, samples)),
            (Codes{0, 3, 128}));
  EXPECT_EQ((there_and_back<std::uint8_t>(settings_of(TexelFormat::kR8, {{"no-data-class", "9"}}, 0.0), {.value_bands = 1, .nodata = 0.0},
                                          samples)),
            (Codes{9, 3, 128}));
  EXPECT_EQ((there_and_back<std::uint8_t>(settings_of(TexelFormat::kR8, {}, -9999.0),
                                          {.type = SampleType::kInt16, .value_bands = 1, .nodata = -9999.0},
                                          std::vector<std::int16_t>{-9999, 0, 91})),
            (Codes{255, 0, 91}));
  const auto codec =
      codec_of(settings_of(TexelFormat::kR16, {}, -9999.0), {.type = SampleType::kInt16, .value_bands = 1, .nodata = -9999.0});
  EXPECT_EQ(codec->class_counting()->no_data, 65535);
  EXPECT_EQ(nlohmann::json::parse(codec->parts()[0].metadata_json)["no_data_class"], 65535);
  const auto zero = codec_of(settings_of(TexelFormat::kR8, {}, 0.0), {.value_bands = 1, .nodata = 0.0});
  EXPECT_TRUE(zero->parts()[0].zero_is_nodata);
  std::uint8_t outside[2] = {5, 6};
  codec_of(settings_of(TexelFormat::kR8), {.value_bands = 1})->mark_outside(0, reinterpret_cast<std::byte*>(outside), 2);
  EXPECT_EQ(outside[0], 255);
  EXPECT_EQ(outside[1], 255);
}

TEST(MaterialCodec, WhatWouldBeWrongIsRefusedWithTheReason) {
  for (const TexelFormat format : {TexelFormat::kBc1, TexelFormat::kBc4, TexelFormat::kBc7})
    EXPECT_NE(refusal_of(settings_of(format)).find("which are other classes; use r8 or r16"), std::string::npos);
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR32Float)).find("use r8 or r16"), std::string::npos);
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR8), {.value_bands = 3}).find("exactly one band"), std::string::npos);
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR16, {{"mixture", "3"}})).find("use mixture 4"), std::string::npos);
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR8, {{"mixture", "5"}})), "");
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR8, {{"no-data-class", "256"}})), "");
  EXPECT_NE(refusal_of(settings_of(TexelFormat::kR8, {{"no-data-class", "1.5"}})).find("whole number"), std::string::npos);
}

TEST(MaterialCodec, TheTableOfClassesIsCheckedAndKept) {
  const auto with = [](const std::string& table) { return settings_of(TexelFormat::kR8, {{"classes", table}}); };
  const auto codec = codec_of(with(R"({"classes": [{"id": 7, "name": "road", "color": [1, 2, 255]},
                                                    {"id": 2, "name": "water", "color": "#0A0b0C"}, {"id": 3, "name": "rock"}]})"),
                              {.value_bands = 1});
  EXPECT_EQ(nlohmann::json::parse(codec->parts()[0].metadata_json)["classes"], nlohmann::json::parse(R"([
      {"id": 2, "name": "water", "color": "#0a0b0c"}, {"id": 3, "name": "rock"}, {"id": 7, "name": "road", "color": "#0102ff"}])"));
  const auto refused = [&](const std::string& table, const std::string& reason) {
    EXPECT_NE(refusal_of(with(table)).find(reason), std::string::npos) << table << ": " << refusal_of(with(table));
  };
  refused("[", "is not JSON");
  refused("7", "neither a list");
  refused("[7]", "entry 1: is not an object");
  refused(R"([{"name": "a"}])", "no whole number \"id\"");
  refused(R"([{"id": 1.5, "name": "a"}])", "no whole number \"id\"");
  refused(R"([{"id": 300, "name": "a"}])", "as r16 it would hold all");
  refused(R"([{"id": -1, "name": "a"}])", "this layer holds 0 to 255");
  refused(R"([{"id": 18446744073709551615, "name": "a"}])", "this layer holds 0 to 255");
  refused(R"([{"id": 255, "name": "a"}])", "stands for no data");
  refused(R"([{"id": 1}])", "no \"name\"");
  refused(R"([{"id": 1, "name": "a"}, {"id": 1, "name": "b"}])", "entry 2: id 1 is there already");
  refused(R"([{"id": 1, "name": "a", "color": "red"}])", "color");
  refused(R"([{"id": 1, "name": "a", "color": [1, 2, 256]}])", "color");
  refused(R"([{"id": 1, "name": "a", "code": 3}])", "member 'code'");
}

// One texel of a mixture of `shares`, encoded.
std::array<int, 4> weights_of(const ChannelCodec& codec, const std::vector<double>& shares) {
  Rows rows(1);
  const PlaneRow row = rows.row(1);
  row[kClassWeightPlane][0] = 1.0F;
  for (std::size_t r = 0; r < shares.size(); ++r) {
    row[static_cast<std::size_t>(class_plane(static_cast<int>(r)))][0] = static_cast<float>(10 + r);
    row[static_cast<std::size_t>(share_plane(static_cast<int>(r)))][0] = static_cast<float>(shares[r]);
  }
  std::array<std::uint8_t, 4> codes{};
  EXPECT_TRUE(codec.encode_row(2, rows.middle(true), 1, reinterpret_cast<std::byte*>(codes.data())).has_value());
  return {codes[0], codes[1], codes[2], codes[3]};
}

TEST(MaterialCodec, WeightsAndTheRestSumTo255) {
  const auto four = codec_of(settings_of(TexelFormat::kR8, {{"mixture", "4"}}), {.value_bands = 1});
  EXPECT_EQ(weights_of(*four, {1.0}), (std::array<int, 4>{255, 0, 0, 0}));
  EXPECT_EQ(weights_of(*four, {0.5, 0.5}), (std::array<int, 4>{128, 127, 0, 0})) << "the half goes to the higher rank";
  EXPECT_EQ(weights_of(*four, {0.4, 0.3, 0.3}), (std::array<int, 4>{102, 77, 76, 0})) << "102, 76.5, 76.5";
  EXPECT_EQ(weights_of(*four, {0.25, 0.25, 0.25, 0.25}), (std::array<int, 4>{64, 64, 64, 63})) << "63.75 each";
  // Random counts: nothing is off by a whole step, and full coverage by four classes leaves no rest.
  std::mt19937 random(8);
  for (int i = 0; i < 20000; ++i) {
    std::array<double, 5> counts{};
    double total = 0.0;
    for (std::size_t c = 0; c < 5; ++c) total += counts[c] = random() % (c == 4 && i % 2 == 0 ? 1 : 1000);
    if (total == 0.0) continue;
    std::sort(counts.begin(), counts.begin() + 4, std::greater<>());
    std::vector<double> shares;
    for (std::size_t c = 0; c < 4; ++c) shares.push_back(counts[c] / total);
    const std::array<int, 4> codes = weights_of(*four, shares);
    int sum = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      sum += codes[c];
      // Shares reach the codec as floats, off by 2^-25 at most: 1e-5 steps.
      ASSERT_LT(std::abs(codes[c] - shares[c] * 255.0), 1.0 + 1e-4);
      if (c > 0) {
        ASSERT_LE(codes[c], codes[c - 1]);
      }
    }
    ASSERT_LT(std::abs(255 - sum - counts[4] / total * 255.0), 1.0 + 1e-4);
    if (counts[4] == 0.0) {
      ASSERT_EQ(sum, 255);
    }
  }
}

TEST(MaterialCodec, AMixtureNamesItsClassesAndNoOthers) {
  const auto codec = codec_of(settings_of(TexelFormat::kR16, {{"mixture", "2"}}), {.type = SampleType::kUint16, .value_bands = 1});
  ASSERT_EQ(codec->parts().size(), 3U);
  EXPECT_EQ(codec->parts()[1].suffix, "classes");
  EXPECT_EQ(codec->parts()[1].format, TexelFormat::kRg16);
  EXPECT_EQ(codec->parts()[2].suffix, "weights");
  EXPECT_EQ(codec->parts()[2].format, TexelFormat::kRg8);
  Rows rows(3);
  const PlaneRow row = rows.row(1);
  // 60 % of 300 and 40 % of 2; all of class 5; nothing.
  row[0][0] = 300.0F, row[1][0] = 1.0F, row[2][0] = 0.6F, row[3][0] = 2.0F, row[4][0] = 0.4F;
  row[0][1] = 5.0F, row[1][1] = 0.25F, row[2][1] = 1.0F;
  std::array<std::uint16_t, 6> classes{};
  EXPECT_TRUE(codec->encode_row(1, rows.middle(false), 3, reinterpret_cast<std::byte*>(classes.data())).has_value());
  EXPECT_EQ(classes, (std::array<std::uint16_t, 6>{300, 2, 5, 65535, 65535, 65535}));
  std::array<std::uint8_t, 6> weights{};
  EXPECT_TRUE(codec->encode_row(2, rows.middle(false), 3, reinterpret_cast<std::byte*>(weights.data())).has_value());
  EXPECT_EQ(weights, (std::array<std::uint8_t, 6>{153, 102, 255, 0, 0, 0}));

  // The majority alone misses 40 points of the first texel, the mixture none.
  std::array<ErrorSum, 2> errors{};
  const std::array<float, 3> majority{300.0F, 5.0F, 65535.0F};
  codec->add_errors(0, rows.middle(false).here, majority.data(), 3, errors);
  const std::array<float, 6> stored{153, 102, 255, 0, 0, 0};
  codec->add_errors(2, rows.middle(false).here, stored.data(), 3, errors);
  EXPECT_EQ(errors[0].count, 2U);
  EXPECT_NEAR(errors[0].largest, 40.0, 1e-5);
  EXPECT_EQ(errors[1].count, 2U);
  EXPECT_NEAR(errors[1].largest, 0.0, 1e-5);
  // A class that the mixture leaves out is missing: 20 points.
  row[2][0] = 0.5F, row[4][0] = 0.3F;
  const std::array<float, 6> rest{127.5F, 76.5F, 255, 0, 0, 0};
  codec->add_errors(2, rows.middle(false).here, rest.data(), 3, errors);
  EXPECT_NEAR(errors[1].largest, 20.0, 1e-5);
}

}  // namespace
}  // namespace vt::channels
