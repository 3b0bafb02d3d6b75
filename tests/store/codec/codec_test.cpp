#include "store/codec/codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using test::Bytes;

Bytes half_random(std::size_t size) {
  Bytes bytes(size);
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < size / 2; ++i) {
    state = state * 1664525 + 1013904223;
    bytes[i] = static_cast<std::byte>(state >> 24);
  }
  return bytes;
}

TEST(Codec, ParsesEveryDocumentedSpelling) {
  EXPECT_EQ(parse_compression("none")->codec, Codec::kRaw);
  for (int level = 1; level <= 19; ++level) {
    const auto compression = parse_compression("zstd:" + std::to_string(level));
    ASSERT_TRUE(compression);
    EXPECT_EQ(compression->codec, Codec::kZstd);
    EXPECT_EQ(compression->level, level);
  }
}

TEST(Codec, RefusesOtherSpellingsAndListsTheRightOnes) {
  for (const char* text : {"", "zstd", "zstd:", "zstd:0", "zstd:20", "zstd:-1", "zstd:3x", "zstd: 3", "lz4", "NONE"}) {
    const auto compression = parse_compression(text);
    ASSERT_FALSE(compression) << text;
    EXPECT_EQ(compression.error().code, ErrorCode::kUsage);
    EXPECT_THAT(compression.error().message, testing::HasSubstr("zstd:N"));
  }
}

TEST(Codec, RoundTripsEverySizeUpToAFewBlocks) {
  for (std::size_t size : {0, 1, 2, 3, 8, 63, 64, 65, 4095, 4096, 100000}) {
    for (const Compression compression : {Compression{}, Compression{Codec::kZstd, 1}, Compression{Codec::kZstd, 9}}) {
      const Bytes raw = half_random(size);
      const auto payload = encode_payload(raw, {}, compression);
      ASSERT_TRUE(payload);
      EXPECT_EQ(payload->raw_bytes, size);
      Bytes back(size);
      ASSERT_TRUE(decode_payload(payload->codec, payload->bytes, {}, back));
      EXPECT_EQ(back, raw);
    }
  }
}

TEST(Codec, KeepsRawWhatDoesNotShrinkByThreePercent) {
  Bytes noise = half_random(20000);
  noise.resize(10000);  // the random half
  EXPECT_EQ(encode_payload(noise, {}, {Codec::kZstd, 9})->codec, Codec::kRaw);
  EXPECT_EQ(encode_payload(half_random(20000), {}, {Codec::kZstd, 9})->codec, Codec::kZstd);
}

TEST(Codec, RefusesEveryTruncationAndEveryWrongSize) {
  const Bytes raw = half_random(300);
  const auto payload = encode_payload(raw, {}, {Codec::kZstd, 3});
  ASSERT_EQ(payload->codec, Codec::kZstd);
  for (std::size_t size = 0; size < payload->bytes.size(); ++size) {
    // A buffer of its own, so that the sanitizer sees a read past its end.
    const Bytes prefix(payload->bytes.begin(), payload->bytes.begin() + static_cast<std::ptrdiff_t>(size));
    Bytes out(raw.size());
    const auto decoded = decode_payload(Codec::kZstd, prefix, {}, out);
    ASSERT_FALSE(decoded) << size;
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
  }
  for (std::size_t size : {0, 299, 301, 1000}) {
    Bytes out(size);
    EXPECT_FALSE(decode_payload(Codec::kZstd, payload->bytes, {}, out)) << size;
    EXPECT_FALSE(decode_payload(Codec::kRaw, raw, {}, out)) << size;
  }
}

TEST(Codec, RefusesTwoFramesWhereOneIsMeant) {
  const std::vector<std::byte> half(1000, std::byte{7});
  const auto frame = encode_payload(half, {}, {Codec::kZstd, 3});
  ASSERT_TRUE(frame.has_value() && frame->codec == Codec::kZstd);
  std::vector<std::byte> twice = frame->bytes;
  twice.insert(twice.end(), frame->bytes.begin(), frame->bytes.end());
  std::vector<std::byte> out(2000);
  const auto decoded = decode_payload(Codec::kZstd, twice, {}, out);
  ASSERT_FALSE(decoded.has_value());
  EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
}

// ---- Prediction ----

constexpr TexelFormat kPredictable[] = {TexelFormat::kRgb8, TexelFormat::kRgba8, TexelFormat::kR32Float, TexelFormat::kRg32Float,
                                        TexelFormat::kRgba32Float};

Bytes smooth(TexelFormat format, int tile_exponent) {
  return test::smooth_tile_bytes(test::small_layer("l", format, tile_exponent, 0), {});
}

TEST(Codec, PredictsEveryFormatThatHasNeighbours) {
  for (const TexelFormat format : kPredictable) {
    const TileShape shape = tile_shape(format, 64);
    const Bytes raw = smooth(format, 6);
    for (const int level : {1, 3, 9, 19}) {
      const auto payload = encode_payload(raw, shape, {Codec::kZstd, level});
      ASSERT_TRUE(payload);
      EXPECT_EQ(payload->codec, Codec::kPredictedZstd) << format_info(format).name << " level " << level;
      EXPECT_LT(payload->bytes.size(), encode_payload(raw, {}, {Codec::kZstd, level})->bytes.size()) << format_info(format).name;
      Bytes back(raw.size());
      ASSERT_TRUE(decode_payload(payload->codec, payload->bytes, shape, back));
      EXPECT_EQ(back, raw);
    }
  }
}

// (zstd itself may be a few bytes larger at 19 than at 15.)
TEST(Codec, NoLevelIsLargerThanTheFirst) {
  for (const TexelFormat format : kPredictable) {
    const auto size_at = [&](int level) {
      return encode_payload(smooth(format, 6), tile_shape(format, 64), {Codec::kZstd, level})->bytes.size();
    };
    const std::size_t first = size_at(1);
    for (const int level : {2, 3, 6, 9, 13, 16, 19}) EXPECT_LE(size_at(level), first) << format_info(format).name << " level " << level;
  }
}

// What prediction would only spoil is left to zstd alone, and noise to nobody.
TEST(Codec, KeepsWhatIsSmallest) {
  const TileShape shape = tile_shape(TexelFormat::kRgb8, 64);
  Bytes pattern = half_random(48);
  pattern.resize(24);
  Bytes repeated;
  while (repeated.size() < shape.raw_bytes()) repeated.insert(repeated.end(), pattern.begin(), pattern.end());
  EXPECT_EQ(encode_payload(repeated, shape, {Codec::kZstd, 1})->codec, Codec::kZstd);
  Bytes noise = half_random(2 * shape.raw_bytes());
  noise.resize(shape.raw_bytes());
  EXPECT_EQ(encode_payload(noise, shape, {Codec::kZstd, 1})->codec, Codec::kRaw);
}

TEST(Codec, NeverPredictsBlocksAndHashes) {
  for (const TexelFormat format : {TexelFormat::kBc1, TexelFormat::kHash128}) {
    const Bytes raw(payload_bytes(format_info(format), 64, 64), std::byte{9});
    EXPECT_EQ(encode_payload(raw, tile_shape(format, 64), {Codec::kZstd, 3})->codec, Codec::kZstd);
  }
}

TEST(Codec, WritesIntoTheSameScratchAgainAndAgain) {
  std::vector<std::byte> scratch;
  for (const TexelFormat format : {TexelFormat::kRgba32Float, TexelFormat::kRgb8, TexelFormat::kRgba8}) {
    const Bytes raw = smooth(format, 6);
    const auto view = encode_payload(raw, tile_shape(format, 64), {Codec::kZstd, 3}, scratch);
    ASSERT_TRUE(view);
    EXPECT_GE(view->bytes.data(), scratch.data());
    EXPECT_LE(view->bytes.data() + view->bytes.size(), scratch.data() + scratch.size());
    Bytes back(raw.size());
    ASSERT_TRUE(decode_payload(view->codec, view->bytes, tile_shape(format, 64), back));
    EXPECT_EQ(back, raw);
  }
}

TEST(Codec, RefusesEveryTruncationOfAPredictedPayload) {
  for (const TexelFormat format : kPredictable) {
    const TileShape shape = tile_shape(format, 16);
    const auto payload = encode_payload(smooth(format, 4), shape, {Codec::kZstd, 1});
    ASSERT_EQ(payload->codec, Codec::kPredictedZstd);
    for (std::size_t size = 0; size < payload->bytes.size(); ++size) {
      const Bytes prefix(payload->bytes.begin(), payload->bytes.begin() + static_cast<std::ptrdiff_t>(size));
      Bytes out(shape.raw_bytes());
      const auto decoded = decode_payload(Codec::kPredictedZstd, prefix, shape, out);
      ASSERT_FALSE(decoded) << size;
      EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
    }
    Bytes longer = payload->bytes;
    longer.push_back(std::byte{0});
    Bytes out(shape.raw_bytes());
    EXPECT_FALSE(decode_payload(Codec::kPredictedZstd, longer, shape, out));
    longer = payload->bytes;
    longer.insert(longer.end(), payload->bytes.begin() + 1 + static_cast<std::ptrdiff_t>(shape.channels), payload->bytes.end());
    EXPECT_FALSE(decode_payload(Codec::kPredictedZstd, longer, shape, out)) << "two frames";
  }
}

// The record's checksum finds damage; here the decoder stands alone, and must only keep to its buffers and to
// its kinds of error.
TEST(Codec, SurvivesEveryBitFlipOfAPredictedPayload) {
  for (const TexelFormat format : kPredictable) {
    const TileShape shape = tile_shape(format, 16);
    const auto payload = encode_payload(smooth(format, 4), shape, {Codec::kZstd, 1});
    for (std::size_t bit = 0; bit < 8 * payload->bytes.size(); ++bit) {
      Bytes damaged = payload->bytes;
      damaged[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
      Bytes out(shape.raw_bytes());
      const auto decoded = decode_payload(Codec::kPredictedZstd, damaged, shape, out);
      EXPECT_TRUE(decoded.has_value() || decoded.error().code == ErrorCode::kCorrupt) << bit;
    }
  }
}

TEST(Codec, RefusesPredictionsThatTheFormatCannotHave) {
  const auto refuses = [](const Bytes& payload, const TileShape& shape) {
    Bytes out(shape.raw_bytes());
    const auto decoded = decode_payload(Codec::kPredictedZstd, payload, shape, out);
    return !decoded && decoded.error().code == ErrorCode::kCorrupt;
  };
  for (const TexelFormat format : kPredictable) {
    const TileShape shape = tile_shape(format, 16);
    const Bytes good = encode_payload(smooth(format, 4), shape, {Codec::kZstd, 1})->bytes;
    EXPECT_FALSE(refuses(good, shape));
    for (int flags = 0; flags < 256; ++flags) {
      Bytes bad = good;
      bad[0] = static_cast<std::byte>(flags);
      EXPECT_EQ(refuses(bad, shape), flags > (shape.samples == TileShape::Samples::kUint8 ? 1 : 0)) << flags;
    }
    for (std::size_t c = 0; c < shape.channels; ++c) {
      for (int predictor = 0; predictor < 256; ++predictor) {
        Bytes bad = good;
        bad[1 + c] = static_cast<std::byte>(predictor);
        EXPECT_EQ(refuses(bad, shape), predictor > 5) << predictor;
      }
    }
    TileShape opaque = shape;
    opaque.samples = TileShape::Samples::kOpaque;
    EXPECT_TRUE(refuses(good, opaque));
  }
}

TEST(Codec, RefusesUnknownCodecs) {
  Bytes out(4);
  EXPECT_EQ(decode_payload(static_cast<Codec>(3), Bytes(4), {}, out).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace vt::store
