#include "builder/channels/normal/normal.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "builder/channels/all_channels.h"
#include "builder/channels/normal/normal_moments.h"
#include "builder/channels/normal/normal_rows.h"
#include "builder/channels/shared/angle.h"
#include "tests/channels/row_fixture.h"

namespace vt::channels {
namespace {

using Vec3 = std::array<double, 3>;

std::unique_ptr<const ChannelCodec> codec_for(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  auto codec = make_codec({.channel = ChannelType::kNormal, .format = format, .options = options}, layout);
  EXPECT_TRUE(codec.has_value()) << (codec ? "" : codec.error().message);
  return codec ? std::move(*codec) : nullptr;
}

std::string refusal(TexelFormat format, const SampleLayout& layout, const Options& options = {}) {
  auto codec = make_codec({.channel = ChannelType::kNormal, .format = format, .options = options}, layout);
  return codec ? "" : codec.error().message;
}

constexpr SampleLayout kFloats{.type = SampleType::kFloat32, .value_bands = 3};

// One decoded row, with room for its neighbours.
struct Decoded {
  template <class T>
  Decoded(const ChannelCodec& codec, const std::vector<T>& samples, int bands)
      : count(static_cast<std::int64_t>(samples.size()) / bands), rows(count) {
    opaque = codec.decode_row(bytes_of(samples), count, rows.row(1));
    codec.derive_row(count, rows.row(1));
  }
  [[nodiscard]] Vec3 vector(std::int64_t i) { return {rows.row(1)[0][i], rows.row(1)[1][i], rows.row(1)[2][i]}; }
  [[nodiscard]] float weight(std::int64_t i) { return rows.row(1)[3][i]; }

  std::int64_t count;
  Rows rows;
  bool opaque = false;
};

// Texels of a part as readers see them: numbers by the part's ranges. `Code` is a sample of the part's
// texel_format.
template <class Code>
std::vector<double> values_of(const ChannelCodec& codec, std::size_t part, Decoded& row) {
  const Part& p = codec.parts()[part];
  const std::size_t components = p.components.size();
  std::vector<Code> codes(static_cast<std::size_t>(row.count) * components);
  EXPECT_TRUE(codec.encode_row(part, row.rows.middle(row.opaque), row.count, reinterpret_cast<std::byte*>(codes.data())).has_value());
  const double codes_per_sample = format_info(p.format).samples == SampleKind::kBlock ? 257.0 : 1.0;
  std::vector<double> values;
  for (std::size_t i = 0; i < codes.size(); ++i)
    values.push_back(p.ranges[i % components].offset + p.ranges[i % components].scale * (codes[i] / codes_per_sample));
  return values;
}

Vec3 unit(Vec3 v) {
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / length, v[1] / length, v[2] / length};
}

Vec3 with_z(double x, double y) { return {x, y, std::sqrt(std::max(0.0, 1.0 - x * x - y * y))}; }

double degrees_between(const Vec3& a, const Vec3& b) { return angle_between(unit(a), unit(b)) / kRadiansPerDegree; }

TEST(AngleBetween, AgreesWithTheArcTangentEverywhere) {
  // The tangent of half the angle between unit vectors is |a - b| / |a + b|: no cancellation at either end.
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = unit({normal(random), normal(random), normal(random)});
    const double size = std::pow(10.0, -8.0 * (i % 100) / 100.0);
    const Vec3 b = unit({a[0] + size * normal(random), a[1] + size * normal(random), a[2] + size * normal(random)});
    double less = 0.0;
    double more = 0.0;
    for (std::size_t c = 0; c < 3; ++c) less += (a[c] - b[c]) * (a[c] - b[c]), more += (a[c] + b[c]) * (a[c] + b[c]);
    const double wanted = 2.0 * std::atan2(std::sqrt(less), std::sqrt(more));
    // Near pi the sine of half the angle rounds: 2 * sqrt(2 * 2^-53) at most.
    EXPECT_NEAR(angle_between(a, b), wanted, wanted < 3.0 ? 1e-11 : 4e-8);
  }
  EXPECT_EQ(angle_between({0, 0, 1}, {0, 0, 1}), 0.0);
  EXPECT_NEAR(angle_between({0, 0, 1}, {0, 0, -1}), std::numbers::pi, 1e-11);
}

TEST(NormalCodec, AFlatSurfaceIsExactlyUpInEveryFormat) {
  const std::vector<float> flat{0.0F, 0.0F, 1.0F};
  const auto check = [&](TexelFormat format, auto code) {
    const auto codec = codec_for(format, kFloats);
    Decoded row(*codec, flat, 3);
    const auto values = values_of<decltype(code)>(*codec, 0, row);
    EXPECT_EQ(values[0], 0.0) << format_info(format).name;
    EXPECT_EQ(values[1], 0.0) << format_info(format).name;
    if (values.size() > 2) {
      EXPECT_NEAR(values[2], 1.0, 1e-15) << format_info(format).name;
    }
    if (values.size() > 3) {
      EXPECT_NEAR(values[3], 1.0, 1e-15);
    } else {
      EXPECT_EQ(codec->parts()[1].suffix, "length");
      const auto lengths = codec->parts()[1].texel_format == TexelFormat::kR8 ? values_of<std::uint8_t>(*codec, 1, row)
                                                                              : values_of<std::uint16_t>(*codec, 1, row);
      EXPECT_NEAR(lengths[0], 1.0, 1e-15);
    }
  };
  check(TexelFormat::kRgb8, std::uint8_t{});
  check(TexelFormat::kRg16, std::uint16_t{});
  check(TexelFormat::kRgba16, std::uint16_t{});
  check(TexelFormat::kBc5, std::uint16_t{});
}

TEST(NormalCodec, CodesMeanWhatTheInputDeclares) {
  const auto first = [](const SampleLayout& layout, const Options& options, auto samples) {
    const auto codec = codec_for(TexelFormat::kRgb8, layout, options);
    Decoded row(*codec, samples, layout.value_bands);
    EXPECT_TRUE(row.opaque);
    return row.vector(0);
  };
  const auto expect = [](const Vec3& is, const Vec3& wanted) { EXPECT_LT(degrees_between(is, wanted), 1e-5); };
  const SampleLayout u8{.type = SampleType::kUint8};
  const SampleLayout u16{.type = SampleType::kUint16};
  using Bytes = std::vector<std::uint8_t>;
  using Words = std::vector<std::uint16_t>;
  EXPECT_EQ(first(u8, {}, Bytes{128, 128, 255}), (Vec3{0, 0, 1}));
  expect(first(u8, {}, Bytes{1, 128, 255}), {-1, 0, 1});
  expect(first(u8, {}, Bytes{0, 128, 255}), {-1, 0, 1});  // code 0 is -1 too, not beyond it
  expect(first(u8, {{"zero", "127.5"}}, Bytes{0, 255, 255}), {-1, 1, 1});
  expect(first(u8, {{"zero", "127.5"}}, Bytes{128, 128, 255}), {0.5 / 127.5, 0.5 / 127.5, 1});
  expect(first(u8, {{"y", "down"}}, Bytes{128, 255, 255}), {0, -1, 1});
  EXPECT_EQ(first(u16, {}, Words{32768, 32768, 65535}), (Vec3{0, 0, 1}));
  expect(first(u16, {{"zero", "127.5"}}, Words{0, 65535, 65535}), {-1, 1, 1});
  expect(first({.type = SampleType::kInt8}, {}, std::vector<std::int8_t>{-127, 0, 127}), {-1, 0, 1});
  expect(first({.type = SampleType::kInt16}, {}, std::vector<std::int16_t>{0, 32767, 32767}), {0, 1, 1});
  expect(first(kFloats, {}, std::vector<float>{2.0F, 0.0F, 2.0F}), {1, 0, 1});
  expect(first({.type = SampleType::kFloat64}, {}, std::vector<double>{0.0, -3.0, 4.0}), {0, -0.6, 0.8});
  // Two components; outside the unit circle z is 0.
  expect(first({.type = SampleType::kFloat32, .value_bands = 2}, {}, std::vector<float>{0.6F, 0.0F}), {0.6, 0, 0.8});
  expect(first({.type = SampleType::kFloat32, .value_bands = 2}, {}, std::vector<float>{3.0F, 4.0F}), {0.6, 0.8, 0});
}

TEST(NormalCodec, WhatHasNoDirectionIsNoData) {
  const float inf = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> samples{0, 0, 0, nan, 0, 1, 0, inf, 1, 1e-40F, 0, 0, 0, 0, nan, -9999, -9999, -9999, 1e30F, 1e30F, 0, 0, 0, 1};
  const auto codec = codec_for(TexelFormat::kRgb8, {.type = SampleType::kFloat32, .value_bands = 3, .nodata = -9999.0});
  Decoded row(*codec, samples, 3);
  EXPECT_FALSE(row.opaque);
  for (std::int64_t i = 0; i < 6; ++i) {
    EXPECT_EQ(row.weight(i), 0.0F) << i;
    EXPECT_EQ(row.vector(i), (Vec3{0, 0, 0})) << i;
  }
  EXPECT_LT(degrees_between(row.vector(6), {1, 1, 0}), 1e-5) << "squares of 1e30 are not floats";
  EXPECT_EQ(row.vector(7), (Vec3{0, 0, 1}));
  // What is stored: lengths of 0 by code, the eastern neighbour's direction where there is one, and up where
  // there is none.
  std::vector<std::uint8_t> lengths(8);
  EXPECT_TRUE(codec->encode_row(1, row.rows.middle(false), 8, reinterpret_cast<std::byte*>(lengths.data())).has_value());
  EXPECT_EQ(lengths, (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 255, 255}));
  EXPECT_TRUE(codec->parts()[1].zero_is_nodata);
  const auto values = values_of<std::uint8_t>(*codec, 0, row);
  EXPECT_EQ(values[2], 1.0);
  EXPECT_NEAR(values[5 * 3], values[6 * 3], 1e-9);

  // All codes as near to 0 as the mapping can say is no direction either.
  const auto codes = codec_for(TexelFormat::kRgb8, {.type = SampleType::kUint8}, {{"zero", "127.5"}});
  Decoded middle(*codes, std::vector<std::uint8_t>{127, 127, 127, 128, 127, 128, 128, 128, 129}, 3);
  EXPECT_EQ(middle.weight(0), 0.0F);
  EXPECT_EQ(middle.weight(1), 0.0F);
  EXPECT_EQ(middle.weight(2), 1.0F);
}

TEST(NormalCodec, WithoutALengthTheDirectionSaysWhereThereAreNoData) {
  const auto codec = codec_for(TexelFormat::kRgb8, kFloats, {{"length", "no"}});
  ASSERT_EQ(codec->parts().size(), 1U);
  EXPECT_TRUE(codec->parts()[0].zero_is_nodata);
  Decoded row(*codec, std::vector<float>{0, 0, 0, -1, 0, 0}, 3);
  std::vector<std::uint8_t> codes(6);
  EXPECT_TRUE(codec->encode_row(0, row.rows.middle(false), 2, reinterpret_cast<std::byte*>(codes.data())).has_value());
  EXPECT_EQ(codes[0], 0);
  EXPECT_EQ(codes[3], 1) << "-1 is code 1: no direction looks like no data";
}

// Half a step in each stored component, seen from the centre: the most that rounding can turn a direction.
TEST(NormalCodec, DirectionsAreWithinHalfAStepOfEachComponent) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::vector<float> samples;
  for (int i = 0; i < 3000; ++i) samples.insert(samples.end(), {normal(random), normal(random), std::abs(normal(random))});
  const auto check = [&](TexelFormat format, auto code, double step) {
    const auto codec = codec_for(format, kFloats);
    Decoded row(*codec, samples, 3);
    const auto values = values_of<decltype(code)>(*codec, 0, row);
    const std::size_t components = codec->parts()[0].components.size();
    for (std::size_t i = 0; i < 3000; ++i) {
      const double* v = &values[i * components];
      const Vec3 wanted = row.vector(static_cast<std::int64_t>(i));
      // A hundredth more for the rounding of floats, 2^-8 of a code at 16 bits.
      const double half = 0.5 * step * 1.01;
      if (components > 2) {
        EXPECT_LE(degrees_between({v[0], v[1], v[2]}, wanted), std::asin(std::sqrt(3.0) * half) / kRadiansPerDegree + 1e-5);
      } else if (wanted[2] > 0.1) {
        // Moving (x, y) by d moves the point on the sphere by at most d / z, z the lower of the two ends.
        const double moved = std::sqrt(2.0) * half;
        const double lowest_z = std::sqrt(wanted[2] * wanted[2] - 2.0 * moved);
        EXPECT_LE(degrees_between(with_z(v[0], v[1]), wanted), moved / lowest_z / kRadiansPerDegree * 1.001 + 1e-5);
      }
    }
  };
  check(TexelFormat::kRgb8, std::uint8_t{}, 1.0 / 127.0);
  check(TexelFormat::kRgba16, std::uint16_t{}, 1.0 / 32767.0);
  check(TexelFormat::kRg16, std::uint16_t{}, 1.0 / 32767.0);
}

TEST(NormalCodec, NormalsThatCancelTakeTheirNeighboursDirection) {
  const auto codec = codec_for(TexelFormat::kRg16, kFloats);
  // Sums of a pair each: (x, -x) cancels; its western neighbour is tilted.
  Decoded row(*codec, std::vector<float>{0.6F, 0, 0.8F, 1, 0, 0, 0, 0, 1, 0, 0, 1}, 3);
  const PlaneRow planes = row.rows.row(1);
  for (std::size_t p = 0; p < 4; ++p) planes[p][1] = 0.0F;
  planes[3][1] = 2.0F;
  for (std::size_t p = 0; p < 4; ++p) planes[p][3] = planes[p][2] = 0.0F;
  planes[3][3] = 2.0F;  // alone
  auto values = values_of<std::uint16_t>(*codec, 0, row);
  EXPECT_NEAR(values[2], 0.6, 1e-4);
  EXPECT_EQ(values[6], 0.0);
  EXPECT_EQ(values[7], 0.0);
  std::vector<std::uint16_t> lengths(4);
  EXPECT_TRUE(codec->encode_row(1, row.rows.middle(false), 4, reinterpret_cast<std::byte*>(lengths.data())).has_value());
  EXPECT_EQ(lengths, (std::vector<std::uint16_t>{65535, 1, 0, 1})) << "length 0 is code 1, no data code 0";
}

TEST(NormalCodec, ADirectionThatLooksDownGoesToTheRimAndSaysSo) {
  const auto codec = codec_for(TexelFormat::kRg16, kFloats);
  Decoded row(*codec, std::vector<float>{0.6F, 0.0F, -0.8F, 0, 0, -1}, 3);
  const auto values = values_of<std::uint16_t>(*codec, 0, row);
  EXPECT_EQ(values[0], 1.0);
  EXPECT_EQ(values[1], 0.0);
  std::vector<LossCount> counts(codec->losses().size());
  codec->count_losses(row.rows.middle(true).here, true, 2, 0, 0, counts);
  ASSERT_EQ(counts.size(), 1U);
  EXPECT_EQ(counts[0].texels, 2U);
  EXPECT_NE(codec->losses()[0].what.find("rg16 cannot say"), std::string::npos);
  std::vector<ErrorSum> errors(2);
  const std::vector<float> stored{65535.0F, 32768.0F, 65535.0F, 32768.0F};
  codec->add_errors(0, row.rows.middle(true).here, stored.data(), 2, errors);
  EXPECT_EQ(errors[0].count, 2U);
  EXPECT_NEAR(errors[0].largest, 90.0, 1e-4);
  EXPECT_NEAR(errors[0].sum, 90.0 + std::asin(0.8) / kRadiansPerDegree, 1e-4);
}

// Normals spread evenly over a spherical cap of half angle a have the mean (1 + cos a) / 2 along its axis.
TEST(NormalCodec, TheMeanOverASphericalCapHasItsClosedFormLength) {
  for (const double cap_deg : {5.0, 30.0, 60.0, 89.0}) {
    constexpr int kCount = 4096;
    const double lowest = std::cos(cap_deg * kRadiansPerDegree);
    std::vector<float> samples;
    for (int i = 0; i < kCount; ++i) {
      const double z = 1.0 - (1.0 - lowest) * (i + 0.5) / kCount;  // equal areas: evenly spaced heights
      const double azimuth = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
      const double across = std::sqrt(1.0 - z * z);
      // Tilted by 20 degrees around y.
      const double tilt = 20.0 * kRadiansPerDegree;
      const double x = across * std::cos(azimuth);
      samples.push_back(static_cast<float>(x * std::cos(tilt) + z * std::sin(tilt)));
      samples.push_back(static_cast<float>(across * std::sin(azimuth)));
      samples.push_back(static_cast<float>(z * std::cos(tilt) - x * std::sin(tilt)));
    }
    const auto codec = codec_for(TexelFormat::kRgba16, kFloats);
    Decoded all(*codec, samples, 3);
    Decoded mean(*codec, std::vector<float>{0, 0, 1}, 3);
    for (std::size_t p = 0; p < 4; ++p) {
      double sum = 0.0;
      for (int i = 0; i < kCount; ++i) sum += all.rows.row(1)[p][i];
      mean.rows.row(1)[p][0] = static_cast<float>(sum / kCount);
    }
    const auto values = values_of<std::uint16_t>(*codec, 0, mean);
    // The spiral is even to about 1 / count.
    EXPECT_NEAR(values[3], 0.5 * (1.0 + lowest), 2e-4) << cap_deg;
    EXPECT_LT(
        degrees_between({values[0], values[1], values[2]}, {std::sin(20.0 * kRadiansPerDegree), 0, std::cos(20.0 * kRadiansPerDegree)}),
        0.03)
        << cap_deg;
  }
}

// What readers make of the two moment parts of a row: means, variances and the covariance.
struct SlopeStatistics {
  double mean_x, mean_y, variance_x, variance_y, covariance;
};
std::vector<SlopeStatistics> slope_statistics(const ChannelCodec& codec, Decoded& row) {
  std::vector<float> along(static_cast<std::size_t>(row.count) * 4);
  std::vector<float> cross(static_cast<std::size_t>(row.count));
  EXPECT_TRUE(codec.encode_row(2, row.rows.middle(row.opaque), row.count, reinterpret_cast<std::byte*>(along.data())).has_value());
  EXPECT_TRUE(codec.encode_row(3, row.rows.middle(row.opaque), row.count, reinterpret_cast<std::byte*>(cross.data())).has_value());
  std::vector<SlopeStatistics> result;
  for (std::size_t i = 0; i < cross.size(); ++i) {
    const std::array<double, 4> m{along[4 * i], along[4 * i + 1], along[4 * i + 2], along[4 * i + 3]};
    result.push_back({m[0], m[1], m[2] - m[0] * m[0], m[3] - m[1] * m[1], static_cast<double>(cross[i]) - m[0] * m[1]});
  }
  return result;
}

// Slopes with a small scatter about a steep mean, halved to one texel as a cascade does it, a plane and its
// remainder at a time. Stored moments are floats: 2^-24 of a mean square and up to two of its steps, which is
// all that the variance is off.
TEST(NormalCodec, MomentsGiveTheSlopesCovarianceOnAnySlope) {
  std::mt19937 random(9);
  constexpr std::int64_t kCount = 1024;
  for (const auto& [slope, scatter] : {std::pair{0.3, 0.4}, {1.0, 0.01}, {3.0, 0.05}, {5.0, 0.1}, {20.0, 0.01}}) {
    std::normal_distribution<double> along_x(slope, scatter);
    std::normal_distribution<double> noise(0.0, 0.5 * scatter);
    std::vector<float> samples;
    for (std::int64_t i = 0; i < kCount; ++i) {
      const double x = along_x(random);
      samples.insert(samples.end(), {static_cast<float>(x), static_cast<float>(0.5 * x + noise(random)), 1.0F});
    }
    const auto codec = codec_for(TexelFormat::kRgb8, kFloats, {{"moments", "lean"}});
    ASSERT_EQ(codec->parts().size(), 4U);
    Decoded all(*codec, samples, 3);
    // The slopes that the planes of the normals stand for, and their statistics in long double.
    std::vector<std::array<long double, 2>> slopes;
    for (std::int64_t i = 0; i < kCount; ++i) {
      const PlaneRow planes = all.rows.row(1);
      slopes.push_back({static_cast<long double>(planes[4][i]), static_cast<long double>(planes[6][i])});
      EXPECT_NEAR(static_cast<double>(slopes.back()[0]), static_cast<double>(planes[0][i]) / planes[2][i], 1e-6 * slope + 1e-7);
    }
    std::array<long double, 2> centre{};
    for (const auto& s : slopes) centre[0] += s[0] / kCount, centre[1] += s[1] / kCount;
    std::array<long double, 3> covariance{};
    for (const auto& s : slopes) {
      covariance[0] += (s[0] - centre[0]) * (s[0] - centre[0]) / kCount;
      covariance[1] += (s[1] - centre[1]) * (s[1] - centre[1]) / kCount;
      covariance[2] += (s[0] - centre[0]) * (s[1] - centre[1]) / kCount;
    }
    Decoded mean(*codec, std::vector<float>{0, 0, 1}, 3);
    for (std::size_t p = 0; p < static_cast<std::size_t>(codec->planes()); ++p) {
      if (codec->rules()[p] == PlaneRule::kRemainder) continue;
      double sum = 0.0;
      const bool has_remainder = p + 1 < static_cast<std::size_t>(codec->planes()) && codec->rules()[p + 1] == PlaneRule::kRemainder;
      for (std::int64_t i = 0; i < kCount; ++i)
        sum += static_cast<double>(all.rows.row(1)[p][i]) + (has_remainder ? static_cast<double>(all.rows.row(1)[p + 1][i]) : 0.0);
      mean.rows.row(1)[p][0] = static_cast<float>(sum / kCount);
      if (has_remainder) mean.rows.row(1)[p + 1][0] = static_cast<float>(sum / kCount - static_cast<double>(mean.rows.row(1)[p][0]));
    }
    const SlopeStatistics is = slope_statistics(*codec, mean).front();
    const double square = slope * slope + scatter * scatter;
    const double tolerance = 3.0 * 0x1p-23 * square;
    EXPECT_NEAR(is.variance_x, static_cast<double>(covariance[0]), tolerance) << slope;
    EXPECT_NEAR(is.variance_y, static_cast<double>(covariance[1]), tolerance) << slope;
    EXPECT_NEAR(is.covariance, static_cast<double>(covariance[2]), tolerance) << slope;
    EXPECT_NEAR(is.mean_x, static_cast<double>(centre[0]), 0x1p-24 * std::abs(slope) * 1.1);
    EXPECT_GE(is.variance_x, static_cast<double>(covariance[0]) - 1e-12 * square) << "rounded up";
  }
}

// One normal has no scatter: what is left is the rounding, upward, and never a matrix with a negative
// eigenvalue. Nor do blends have one, which are what a texture unit makes of stored moments.
TEST(NormalCodec, CovarianceMatricesArePositiveAtTheFinestLevelToo) {
  std::mt19937 random(2);
  std::normal_distribution<float> slope(0.0F, 3.0F);
  std::vector<float> samples;
  for (int i = 0; i < 4000; ++i) samples.insert(samples.end(), {slope(random), slope(random), 1.0F});
  const auto codec = codec_for(TexelFormat::kRgba16, kFloats, {{"moments", "lean"}});
  Decoded row(*codec, samples, 3);
  std::vector<float> along(4 * 4000);
  std::vector<float> cross(4000);
  ASSERT_TRUE(codec->encode_row(1, row.rows.middle(true), 4000, reinterpret_cast<std::byte*>(along.data())).has_value());
  ASSERT_TRUE(codec->encode_row(2, row.rows.middle(true), 4000, reinterpret_cast<std::byte*>(cross.data())).has_value());
  for (std::size_t i = 0; i < 4000; ++i) {
    const double x = along[4 * i], y = along[4 * i + 1];
    const double xx = along[4 * i + 2] - x * x, yy = along[4 * i + 3] - y * y, xy = cross[i] - x * y;
    ASSERT_GE(xx, 0.0);
    ASSERT_GE(yy, 0.0);
    ASSERT_GE(xx * yy, xy * xy) << i;
    ASSERT_LE(xx + yy, 0x1p-22 * (x * x + y * y));
  }
}

// On a height field the mean slope over a block is the difference of the heights at the block's edges:
// moments and overviews of elevation agree, where the mean normal does not.
TEST(NormalCodec, MeanSlopesAreThoseOfTheFilteredHeights) {
  constexpr int kWidth = 64;
  const auto height = [](double x) { return 3.0 * std::sin(0.37 * x) + 0.02 * x * x; };
  std::vector<float> samples;
  for (int i = 0; i < kWidth; ++i) samples.insert(samples.end(), {static_cast<float>(height(i) - height(i + 1)), 0.0F, 1.0F});
  const auto codec = codec_for(TexelFormat::kRgb8, kFloats, {{"moments", "lean"}});
  Decoded row(*codec, samples, 3);
  double sum = 0.0;
  for (int i = 0; i < kWidth; ++i) sum += row.rows.row(1)[4][i];
  EXPECT_NEAR(sum / kWidth, -(height(kWidth) - height(0)) / kWidth, 1e-6);
}

TEST(NormalCodec, GrazingNormalsHaveFiniteMoments) {
  const auto codec = codec_for(TexelFormat::kRgb8, kFloats, {{"moments", "lean"}});
  Decoded row(*codec, std::vector<float>{1, 0, 0, 0, 1, -1, 1, 0, 1e-3F, 0, 0, -1, 0, 0, 0}, 3);
  std::vector<float> moments(5 * 4);
  EXPECT_TRUE(codec->encode_row(2, row.rows.middle(false), 5, reinterpret_cast<std::byte*>(moments.data())).has_value());
  for (std::size_t i = 0; i < 16; ++i) EXPECT_TRUE(std::isfinite(moments[i])) << i;
  EXPECT_EQ(moments[0], kSteepestSlope);
  EXPECT_EQ(moments[5], kSteepestSlope);
  for (std::size_t i = 16; i < 20; ++i)
    EXPECT_EQ(std::bit_cast<std::uint32_t>(moments[i]), 0x7FC00000U) << "the one NaN that the format document names";
}

TEST(NormalCodec, RefusesWhatWouldBeWrongAndSaysWhatToUse) {
  for (const TexelFormat format : {TexelFormat::kBc1, TexelFormat::kBc3, TexelFormat::kBc7})
    EXPECT_NE(refusal(format, kFloats).find("by degrees; use rgb8, rg16, rgba16 or bc5"), std::string::npos);
  for (const TexelFormat format : {TexelFormat::kRg16, TexelFormat::kBc5})
    EXPECT_NE(refusal(format, kFloats, {{"frame", "scene"}}).find("z may be negative; use rgb8 or rgba16"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgb8, kFloats, {{"frame", "scene"}, {"moments", "lean"}}).find("vertical"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kR32Float, kFloats).find("use rgb8, rg16, rgba16 or bc5"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgb8, {.type = SampleType::kUint8, .value_bands = 1}).find("`bands`"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgb8, {.type = SampleType::kInt32}).find("8 or 16 bits"), std::string::npos);
  EXPECT_NE(refusal(TexelFormat::kRgb8, kFloats, {{"frame", "tangent"}}).find("none of enu, scene"), std::string::npos);
}

TEST(NormalCodec, NamesItsFrameInEveryPart) {
  EXPECT_EQ(codec_for(TexelFormat::kRgb8, kFloats)->parts()[0].components, (std::vector<std::string>{"east", "north", "up"}));
  EXPECT_EQ(codec_for(TexelFormat::kRgba16, kFloats, {{"frame", "scene"}})->parts()[0].components,
            (std::vector<std::string>{"x", "y", "z", "length"}));
  EXPECT_EQ(codec_for(TexelFormat::kBc5, kFloats)->parts()[0].components, (std::vector<std::string>{"east", "north"}));
}

}  // namespace
}  // namespace vt::channels
