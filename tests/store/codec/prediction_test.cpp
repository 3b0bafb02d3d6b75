// Predictors against the definition in tests/support/naive_prediction.h, over every predictor, shape and kind
// of content.
#include "store/codec/prediction.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <set>
#include <stdexcept>

#include "store/io/bytes.h"
#include "store/texel/half.h"
#include "tests/store/store_support.h"
#include "tests/support/naive_prediction.h"

namespace vt::store {
namespace {

using test::Bytes;
using vt::test::naive_planes;
using vt::test::naive_texels;
using vt::test::NaivePrediction;

using Samples = TileShape::Samples;

struct Numbers {
  std::size_t bytes = 0;
  bool is_float = false;
};
Numbers numbers_of(Samples samples) {
  switch (samples) {
    case Samples::kUint8:
      return {1, false};
    case Samples::kUint16:
      return {2, false};
    case Samples::kFloat16:
      return {2, true};
    case Samples::kFloat32:
      return {4, true};
    case Samples::kOpaque:
      break;
  }
  throw std::runtime_error("samples that nobody predicts");
}

NaivePrediction definition_of(const TileShape& shape, const Prediction& prediction) {
  const Numbers numbers = numbers_of(shape.samples);
  NaivePrediction naive{.sample_bytes = numbers.bytes,
                        .is_float = numbers.is_float,
                        .width = shape.width,
                        .height = shape.height,
                        .subtracts_green = prediction.subtracts_green,
                        .predictors = {}};
  for (std::size_t c = 0; c < shape.channels; ++c) naive.predictors.push_back(static_cast<unsigned>(prediction.predictors[c]));
  return naive;
}

// All predictors alike, for all channels; then mixtures.
std::vector<Prediction> predictions_of(const TileShape& shape) {
  std::vector<Prediction> all;
  for (std::size_t p = 0; p < 2 * kPredictorCount; ++p) {
    Prediction prediction;
    for (std::size_t c = 0; c < shape.channels; ++c)
      prediction.predictors[c] = static_cast<Predictor>((p + (p < kPredictorCount ? 0 : c * (p % 3 + 1))) % kPredictorCount);
    all.push_back(prediction);
    if (shape.samples != Samples::kUint8 || shape.channels < 3) continue;
    prediction.subtracts_green = true;
    all.push_back(prediction);
  }
  return all;
}

const std::vector<std::pair<std::size_t, std::size_t>> kSizes = {{1, 1}, {2, 1}, {1, 2}, {3, 2},   {1, 17}, {17, 1},
                                                                 {4, 4}, {5, 7}, {8, 8}, {33, 31}, {64, 3}, {67, 16}};

std::vector<TileShape> small_shapes() {
  std::set<Samples> kinds;
  for (const FormatInfo& info : kTexelFormats)
    if (const TileShape shape = tile_shape(info.format, 1); shape.is_predictable()) kinds.insert(shape.samples);
  std::vector<TileShape> shapes;
  for (const Samples samples : kinds)
    for (std::size_t channels = 1; channels <= 4; ++channels)
      for (const auto& [width, height] : kSizes)
        shapes.push_back({.samples = samples, .width = width, .height = height, .channels = channels});
  return shapes;
}

std::string name_of(const TileShape& shape, const Prediction& prediction) {
  std::string name = "samples of kind " + std::to_string(static_cast<int>(shape.samples)) + ", " + std::to_string(shape.width) + " x " +
                     std::to_string(shape.height) + ", predictors";
  for (std::size_t c = 0; c < shape.channels; ++c) name += " " + std::to_string(static_cast<int>(prediction.predictors[c]));
  return name + (prediction.subtracts_green ? ", less green" : "");
}

Bytes random_bytes(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

// Noise; steps between the ends of the range; slopes that wrap around; one value.
std::vector<Bytes> contents_of(const TileShape& shape) {
  std::vector<Bytes> contents = {random_bytes(shape.raw_bytes(), 7)};
  Bytes extremes = random_bytes(shape.raw_bytes(), 8);
  Bytes slopes(shape.raw_bytes());
  for (std::size_t i = 0; i < extremes.size(); ++i) {
    extremes[i] = std::to_integer<int>(extremes[i]) < 128 ? std::byte{0} : std::byte{255};
    slopes[i] = static_cast<std::byte>(i * 3 + i / 16);
  }
  contents.push_back(extremes);
  contents.push_back(slopes);
  contents.emplace_back(shape.raw_bytes(), std::byte{0x7F});
  return contents;
}

TEST(Prediction, SplitsAsDefined) {
  for (const TileShape& shape : small_shapes()) {
    for (const Prediction& prediction : predictions_of(shape)) {
      for (const Bytes& raw : contents_of(shape)) {
        Bytes planes(raw.size());
        split_into_residuals(raw, shape, prediction, planes);
        ASSERT_EQ(planes, naive_planes(raw, definition_of(shape, prediction))) << name_of(shape, prediction);
      }
    }
  }
}

// Planes of any content at all, as a hostile file may have them.
TEST(Prediction, JoinsAsDefined) {
  for (const TileShape& shape : small_shapes()) {
    for (const Prediction& prediction : predictions_of(shape)) {
      for (const Bytes& planes : contents_of(shape)) {
        Bytes raw(planes.size());
        join_residuals(planes, shape, prediction, raw);
        ASSERT_EQ(raw, naive_texels(planes, definition_of(shape, prediction))) << name_of(shape, prediction);
      }
    }
  }
}

TEST(Prediction, JoiningUndoesSplittingForWholeTiles) {
  for (const TexelFormat format : {TexelFormat::kR8, TexelFormat::kRg8, TexelFormat::kRgb8, TexelFormat::kRgba8, TexelFormat::kR16,
                                   TexelFormat::kRg16, TexelFormat::kRgba16, TexelFormat::kR16Float, TexelFormat::kRg16Float,
                                   TexelFormat::kRgba16Float, TexelFormat::kR32Float, TexelFormat::kRg32Float, TexelFormat::kRgba32Float}) {
    for (const std::size_t edge : {4, 64, 256}) {
      const TileShape shape = tile_shape(format, edge);
      for (const Bytes& raw : contents_of(shape)) {
        const Prediction prediction = choose_prediction(raw, shape);
        Bytes planes(raw.size());
        Bytes back(raw.size());
        split_into_residuals(raw, shape, prediction, planes);
        join_residuals(planes, shape, prediction, back);
        ASSERT_EQ(back, raw) << name_of(shape, prediction);
      }
    }
  }
}

// Lossless by bits: every NaN, both zeros, denormals and infinities keep theirs.
TEST(Prediction, KeepsTheBitsOfEveryKindOfFloat) {
  const std::vector<std::uint32_t> kinds = {0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007FFFFF, 0x00800000,
                                            0x3F800000, 0xBF800000, 0x7F7FFFFF, 0xFF7FFFFF, 0x7F800000, 0xFF800000,
                                            0x7FC00000, 0xFFC00000, 0x7F800001, 0xFFFFFFFF, 0x7FFFFFFF, 0xFFABCDEF};
  const TileShape shape{.samples = Samples::kFloat32, .width = kinds.size(), .height = kinds.size(), .channels = 1};
  Bytes raw(shape.raw_bytes());
  for (std::size_t y = 0; y < shape.height; ++y)
    for (std::size_t x = 0; x < shape.width; ++x) put<std::uint32_t>(raw, 4 * (y * shape.width + x), kinds[(x * (y + 1)) % kinds.size()]);
  for (const Prediction& prediction : predictions_of(shape)) {
    Bytes planes(raw.size());
    Bytes back(raw.size());
    split_into_residuals(raw, shape, prediction, planes);
    EXPECT_EQ(planes, naive_planes(raw, definition_of(shape, prediction)));
    join_residuals(planes, shape, prediction, back);
    EXPECT_EQ(back, raw);
  }
}

// Every half there is, beside every other kind of neighbour that a shuffled order brings.
TEST(Prediction, KeepsTheBitsOfEveryHalfAndEveryCode) {
  for (const Samples samples : {Samples::kUint16, Samples::kFloat16}) {
    const TileShape shape{.samples = samples, .width = 256, .height = 256, .channels = 1};
    Bytes raw(shape.raw_bytes());
    for (std::size_t i = 0; i < 65536; ++i) put<std::uint16_t>(raw, 2 * i, static_cast<std::uint16_t>(i * 40503));  // odd: each once
    for (const Prediction& prediction : predictions_of(shape)) {
      Bytes planes(raw.size());
      Bytes back(raw.size());
      split_into_residuals(raw, shape, prediction, planes);
      EXPECT_EQ(planes, naive_planes(raw, definition_of(shape, prediction))) << name_of(shape, prediction);
      join_residuals(planes, shape, prediction, back);
      EXPECT_EQ(back, raw) << name_of(shape, prediction);
    }
  }
}

// A surface that goes through zero: in the order of the floats its halves step evenly, as codes they would
// jump by 32768.
TEST(Prediction, HalvesOfBothSignsAreNeighbours) {
  const TileShape shape = tile_shape(TexelFormat::kR16Float, 64);
  Bytes raw(shape.raw_bytes());
  for (std::size_t i = 0; i < 64 * 64; ++i)
    put<std::uint16_t>(raw, 2 * i, half_from_float((static_cast<float>(i % 64) - 31.5F) * 1e-6F));  // subnormal, where steps are even
  Bytes planes(raw.size());
  split_into_residuals(raw, shape, {false, {Predictor::kLeft}}, planes);
  for (std::size_t i = 0; i < shape.plane_bytes(); ++i)
    if (i % 64 != 0) {
      ASSERT_EQ(planes[i], std::byte{0}) << i;  // no step needs the upper byte
    }
}

// ---- Choosing: pictures of which one knows what foretells them ----

constexpr std::size_t kEdge = 64;

template <class Value>
Bytes painted(const TileShape& shape, Value&& value) {
  Bytes raw(shape.raw_bytes());
  for (std::size_t y = 0; y < shape.height; ++y) {
    for (std::size_t x = 0; x < shape.width; ++x) {
      for (std::size_t c = 0; c < shape.channels; ++c) {
        const std::size_t sample = (y * shape.width + x) * shape.channels + c;
        if (shape.samples == Samples::kUint8) {
          raw[sample] = static_cast<std::byte>(static_cast<int>(value(x, y, c)));
        } else if (shape.samples == Samples::kUint16) {
          put<std::uint16_t>(raw, 2 * sample, static_cast<std::uint16_t>(static_cast<int>(value(x, y, c))));
        } else if (shape.samples == Samples::kFloat16) {
          put<std::uint16_t>(raw, 2 * sample, half_from_float(static_cast<float>(value(x, y, c))));
        } else {
          put<std::uint32_t>(raw, 4 * sample, std::bit_cast<std::uint32_t>(static_cast<float>(value(x, y, c))));
        }
      }
    }
  }
  return raw;
}

// The same number for the same place, with nothing in common between neighbours.
int noise(std::size_t x, std::size_t y, int range) {
  std::uint32_t state = static_cast<std::uint32_t>(x * 7919 + y * 104729 + 1) * 2654435761U;
  state ^= state >> 15;
  state *= 2246822519U;
  state ^= state >> 13;
  return static_cast<int>(state % static_cast<std::uint32_t>(range));
}

TEST(Prediction, ChoosesLeftForRowsAndUpForColumns) {
  for (const TexelFormat format :
       {TexelFormat::kRgb8, TexelFormat::kRg8, TexelFormat::kR16, TexelFormat::kR16Float, TexelFormat::kR32Float}) {
    const TileShape shape = tile_shape(format, kEdge);
    const Bytes rows = painted(shape, [](std::size_t, std::size_t y, std::size_t c) { return noise(c, y, 256); });
    const Bytes columns = painted(shape, [](std::size_t x, std::size_t, std::size_t c) { return noise(x, c, 256); });
    // Exact in the gradient and the median as well, but left and up come first.
    EXPECT_EQ(choose_prediction(rows, shape).predictors[0], Predictor::kLeft);
    EXPECT_EQ(choose_prediction(columns, shape).predictors[0], Predictor::kUp);
  }
}

TEST(Prediction, ChoosesTheAverageForNoiseOnASlope) {
  const TileShape shape = tile_shape(TexelFormat::kRgb8, kEdge);
  const auto sum = [](std::size_t x, std::size_t y) { return noise(x, y, 8) + noise(x + 1000, y, 8) + noise(x, y + 1000, 8); };
  const Bytes raw = painted(shape, [&](std::size_t x, std::size_t y, std::size_t c) { return 2 * x + y + sum(x + 200 * c, y); });
  EXPECT_EQ(choose_prediction(raw, shape), (Prediction{false, {Predictor::kAverage, Predictor::kAverage, Predictor::kAverage}}));
}

TEST(Prediction, ChoosesTheGradientOnASlope) {
  for (const TexelFormat format : {TexelFormat::kR16, TexelFormat::kR32Float}) {
    const TileShape shape = tile_shape(format, kEdge);
    // Both ways curved, so that differences themselves differ.
    const Bytes raw = painted(shape, [](std::size_t x, std::size_t y, std::size_t) { return 4096.0 + 3.0 * x * x + 5.0 * y * y; });
    EXPECT_EQ(choose_prediction(raw, shape).predictors[0], Predictor::kGradient);
  }
}

TEST(Prediction, SubtractsGreenWhereChannelsGoTogether) {
  const TileShape shape = tile_shape(TexelFormat::kRgb8, kEdge);
  const Bytes gray = painted(shape, [](std::size_t x, std::size_t y, std::size_t c) { return noise(x, y, 200) + static_cast<int>(c); });
  const Bytes apart = painted(shape, [](std::size_t x, std::size_t y, std::size_t c) { return noise(x + 100 * c, y, 16); });
  EXPECT_TRUE(choose_prediction(gray, shape).subtracts_green);
  EXPECT_FALSE(choose_prediction(apart, shape).subtracts_green);
}

// One channel in rows, one in columns: each has its own predictor.
TEST(Prediction, ChoosesForEachChannelWhereThatPays) {
  const TileShape shape = tile_shape(TexelFormat::kRg32Float, kEdge);
  const Bytes raw =
      painted(shape, [](std::size_t x, std::size_t y, std::size_t c) { return c == 0 ? noise(0, y, 4096) : noise(x, 0, 4096); });
  EXPECT_EQ(choose_prediction(raw, shape).predictors[0], Predictor::kLeft);
  EXPECT_EQ(choose_prediction(raw, shape).predictors[1], Predictor::kUp);
}

TEST(Prediction, ShapesFollowFromFormats) {
  EXPECT_EQ(tile_shape(TexelFormat::kRgba32Float, 256).raw_bytes(), payload_bytes(format_info(TexelFormat::kRgba32Float), 256, 256));
  EXPECT_EQ(tile_shape(TexelFormat::kRgb8, 4).raw_bytes(), 48U);
  EXPECT_FALSE(tile_shape(TexelFormat::kBc1, 256).is_predictable());
  for (std::uint16_t n = 1; const auto format = format_from_number(n); ++n) {
    const TileShape shape = tile_shape(*format, 16);
    const FormatInfo& info = format_info(*format);
    EXPECT_EQ(shape.is_predictable(), sample_bytes(info.samples) > 0) << info.name;
    if (shape.is_predictable()) {
      EXPECT_EQ(shape.raw_bytes(), payload_bytes(info, 16, 16)) << info.name;
    }
  }
}

}  // namespace
}  // namespace vt::store
