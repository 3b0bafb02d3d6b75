#include "store/codec.h"

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
      const auto payload = encode_payload(raw, compression);
      ASSERT_TRUE(payload);
      EXPECT_EQ(payload->raw_bytes, size);
      Bytes back(size);
      ASSERT_TRUE(decode_payload(payload->codec, payload->bytes, back));
      EXPECT_EQ(back, raw);
    }
  }
}

TEST(Codec, KeepsRawWhatDoesNotShrinkByThreePercent) {
  Bytes noise = half_random(20000);
  noise.resize(10000);  // the random half
  EXPECT_EQ(encode_payload(noise, {Codec::kZstd, 9})->codec, Codec::kRaw);
  EXPECT_EQ(encode_payload(half_random(20000), {Codec::kZstd, 9})->codec, Codec::kZstd);
}

TEST(Codec, RefusesEveryTruncationAndEveryWrongSize) {
  const Bytes raw = half_random(300);
  const auto payload = encode_payload(raw, {Codec::kZstd, 3});
  ASSERT_EQ(payload->codec, Codec::kZstd);
  for (std::size_t size = 0; size < payload->bytes.size(); ++size) {
    // A buffer of its own, so that the sanitizer sees a read past its end.
    const Bytes prefix(payload->bytes.begin(), payload->bytes.begin() + static_cast<std::ptrdiff_t>(size));
    Bytes out(raw.size());
    const auto decoded = decode_payload(Codec::kZstd, prefix, out);
    ASSERT_FALSE(decoded) << size;
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
  }
  for (std::size_t size : {0, 299, 301, 1000}) {
    Bytes out(size);
    EXPECT_FALSE(decode_payload(Codec::kZstd, payload->bytes, out)) << size;
    EXPECT_FALSE(decode_payload(Codec::kRaw, raw, out)) << size;
  }
}

TEST(Codec, RefusesTwoFramesWhereOneIsMeant) {
  const std::vector<std::byte> half(1000, std::byte{7});
  const auto frame = encode_payload(half, {Codec::kZstd, 3});
  ASSERT_TRUE(frame.has_value() && frame->codec == Codec::kZstd);
  std::vector<std::byte> twice = frame->bytes;
  twice.insert(twice.end(), frame->bytes.begin(), frame->bytes.end());
  std::vector<std::byte> out(2000);
  const auto decoded = decode_payload(Codec::kZstd, twice, out);
  ASSERT_FALSE(decoded.has_value());
  EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
}

TEST(Codec, RefusesUnknownCodecs) {
  Bytes out(4);
  EXPECT_EQ(decode_payload(static_cast<Codec>(2), Bytes(4), out).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace vt::store
