// Coverage beside the values of channels that do not weigh with it themselves: the planes of the values,
// multiplied by it.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "builder/channels/all_channels.h"
#include "builder/channels/codec/channel_codec.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

struct Kind {
  std::string name;
  ChannelType channel;
  TexelFormat format;
  SampleType type;
  int value_bands;
  Options options;
  bool is_all_or_none = false;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> made = {
      {"elevation", ChannelType::kElevation, TexelFormat::kR32Float, SampleType::kFloat32, 1, {}},
      {"elevation of int16", ChannelType::kElevation, TexelFormat::kR32Float, SampleType::kInt16, 1, {{"bounds", "yes"}}},
      {"sensor", ChannelType::kSensor, TexelFormat::kR32Float, SampleType::kUint16, 1, {}},
      {"temperature",
       ChannelType::kSensor,
       TexelFormat::kR32Float,
       SampleType::kFloat32,
       1,
       {{"quantity", "temperature"}, {"band", "8,12"}}},
      {"normal", ChannelType::kNormal, TexelFormat::kRgb8, SampleType::kUint8, 3, {}},
      {"normal of two", ChannelType::kNormal, TexelFormat::kRg16, SampleType::kFloat32, 2, {}},
      {"horizon", ChannelType::kHorizon, TexelFormat::kRgba16, SampleType::kFloat32, 2, {}},
      {"horizon with deviations", ChannelType::kHorizon, TexelFormat::kRgba16, SampleType::kFloat32, 4, {{"deviations", "given"}}},
      {"material", ChannelType::kMaterial, TexelFormat::kR8, SampleType::kUint8, 1, {}, true},
  };
  return made;
}

// A value that every kind takes: small numbers, differing from texel to texel.
double value_of(const Kind& kind, std::int64_t i, int band) {
  if (is_floating_point(kind.type))
    return kind.channel == ChannelType::kSensor ? 280.0 + static_cast<double>(i % 17) : 0.01 * static_cast<double>((i + band) % 50);
  return static_cast<double>(20 + (7 * i + band) % 100);
}

void put(SampleType type, double value, std::vector<std::byte>& out) {
  const auto add = [&](auto typed) {
    const auto* bytes = reinterpret_cast<const std::byte*>(&typed);
    out.insert(out.end(), bytes, bytes + sizeof typed);
  };
  switch (type) {
    case SampleType::kUint8:
      return add(static_cast<std::uint8_t>(value));
    case SampleType::kInt16:
      return add(static_cast<std::int16_t>(value));
    case SampleType::kUint16:
      return add(static_cast<std::uint16_t>(value));
    default:
      return add(static_cast<float>(value));
  }
}

std::unique_ptr<const ChannelCodec> codec_of(const Kind& kind, const SampleLayout& layout) {
  auto codec = make_codec({.channel = kind.channel, .format = kind.format, .options = kind.options}, layout);
  EXPECT_TRUE(codec.has_value()) << kind.name << ": " << (codec ? "" : codec.error().message);
  return codec ? std::move(*codec) : nullptr;
}

TEST(CoveredSamples, PlanesAreThoseOfTheValuesTimesCoverage) {
  constexpr std::int64_t kCount = 300;  // more than is taken apart at once, and no multiple of it
  constexpr double kFull = 80.0;        // not the type's own full scale
  int compared = 0;
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const SampleLayout plain{.type = kind.type, .value_bands = kind.value_bands};
    SampleLayout covered = plain;
    covered.has_alpha = true;
    covered.alpha_full_scale = kFull;
    const auto of_values = codec_of(kind, plain);
    const auto of_both = codec_of(kind, covered);
    ASSERT_TRUE(of_values && of_both);
    ASSERT_EQ(of_values->source_planes(), of_both->source_planes());
    EXPECT_FALSE(of_both->samples_are_texels());

    std::vector<std::byte> values;
    std::vector<std::byte> both;
    std::vector<double> coverage;
    for (std::int64_t i = 0; i < kCount; ++i) {
      coverage.push_back(i % 5 == 0 ? 0.0 : i % 5 == 1 ? kFull : i % 5 == 2 ? kFull + 9.0 : 0.25 * kFull * static_cast<double>(i % 5 - 2));
      for (int b = 0; b < kind.value_bands; ++b) {
        put(kind.type, value_of(kind, i, b), values);
        put(kind.type, value_of(kind, i, b), both);
      }
      put(kind.type, coverage.back(), both);
    }
    Rows expected(kCount);
    Rows got(kCount);
    EXPECT_TRUE(of_values->decode_row(values.data(), kCount, expected.row(1)));
    EXPECT_FALSE(of_both->decode_row(both.data(), kCount, got.row(1)));
    for (std::int64_t i = 0; i < kCount; ++i) {
      double share = std::min(coverage[static_cast<std::size_t>(i)] / kFull, 1.0);
      if (kind.is_all_or_none) share = share >= 0.5 ? 1.0 : 0.0;
      for (std::size_t p = 0; p < static_cast<std::size_t>(of_both->source_planes()); ++p) {
        EXPECT_EQ(got.row(1)[p][i], static_cast<float>(share) * expected.row(1)[p][i]) << "texel " << i << ", plane " << p;
        ++compared;
      }
    }
    // All of it covered is as if there were no coverage.
    for (std::int64_t i = 0; i < kCount; ++i) {
      const std::size_t at = (static_cast<std::size_t>(i) + 1) * covered.texel_bytes() - sample_bytes(kind.type);
      std::vector<std::byte> full;
      put(kind.type, kFull, full);
      std::memcpy(both.data() + at, full.data(), full.size());
    }
    EXPECT_TRUE(of_both->decode_row(both.data(), kCount, got.row(1)));
  }
  EXPECT_GT(compared, 9 * 300);
}

}  // namespace
}  // namespace vt::channels
