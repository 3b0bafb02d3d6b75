#include "builder/encode/bc4/bc4_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "store/texel/bc4.h"
#include "tests/encode/bc4/bc4_images.h"
#include "tests/encode/simd_targets.h"

namespace vt::encode {
namespace {

constexpr Quality kQualities[] = {Quality::kFast, Quality::kNormal, Quality::kBest};

// Truth in whole numbers: 35 * 257 parts to a code, as the palette of a pair has sevenths and fifths.
constexpr std::int64_t kParts = 35;
std::array<std::int64_t, 8> palette_in_parts(int r0, int r1) {
  std::array<std::int64_t, 8> palette{r0 * kParts * 257, r1 * kParts * 257};
  for (int i = 1; i < 7; ++i) palette[static_cast<std::size_t>(i + 1)] = ((7 - i) * r0 + i * r1) * kParts / 7 * 257;
  if (r0 > r1) return palette;
  for (int i = 1; i < 5; ++i) palette[static_cast<std::size_t>(i + 1)] = ((5 - i) * r0 + i * r1) * kParts / 5 * 257;
  palette[6] = 0;
  palette[7] = 255 * kParts * 257;
  return palette;
}

// Least squared error over the indices, in parts squared; broken off above `limit`.
std::int64_t least_error(const Block16& texels, int r0, int r1, std::int64_t limit) {
  const auto palette = palette_in_parts(r0, r1);
  std::int64_t sum = 0;
  for (const std::uint16_t texel : texels) {
    std::int64_t nearest = INT64_MAX;
    for (const std::int64_t value : palette) nearest = std::min(nearest, (texel * kParts - value) * (texel * kParts - value));
    sum += nearest;
    if (sum > limit) break;
  }
  return sum;
}

std::int64_t error_in_parts(const Block16& texels, std::span<const std::byte> block) {
  const auto palette = palette_in_parts(std::to_integer<int>(block[0]), std::to_integer<int>(block[1]));
  std::uint64_t indices = 0;
  for (std::size_t i = 0; i < 6; ++i) indices |= std::to_integer<std::uint64_t>(block[i + 2]) << (8 * i);
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < 16; ++i) {
    const std::int64_t d = texels[i] * kParts - palette[indices >> (3 * i) & 7U];
    sum += d * d;
  }
  return sum;
}

TEST(Bc4Encoder, BestIsTheOptimumOverAllPairsOfEndPoints) {
  for (const auto& [name, image] : scalar_images(24)) {
    const std::vector<std::byte> blocks = encoded(image, Quality::kBest);
    for (std::size_t i = 0; i < blocks.size() / 8; ++i) {
      const Block16 texels = block_of(image, i);
      const std::int64_t found = error_in_parts(texels, std::span(blocks).subspan(i * 8, 8));
      std::int64_t least = found;
      for (int r0 = 0; r0 < 256; ++r0)
        for (int r1 = 0; r1 < 256; ++r1) least = std::min(least, least_error(texels, r0, r1, least));
      // What the header promises: float rounding, one part in 100 000.
      EXPECT_LE(static_cast<double>(found), static_cast<double>(least) * (1 + 1e-5)) << name << ", block " << i;
    }
  }
}

TEST(Bc4Encoder, IndicesAreTheNearestOfThePalette) {
  for (const Quality quality : kQualities) {
    for (const auto& [name, image] : scalar_images(64)) {
      const std::vector<std::byte> blocks = encoded(image, quality);
      for (std::size_t i = 0; i < blocks.size() / 8; ++i) {
        const auto block = std::span(blocks).subspan(i * 8, 8);
        const Block16 texels = block_of(image, i);
        const std::int64_t least = least_error(texels, std::to_integer<int>(block[0]), std::to_integer<int>(block[1]), INT64_MAX);
        ASSERT_LE(static_cast<double>(error_in_parts(texels, block)), static_cast<double>(least) * (1 + 1e-5)) << name << ", block " << i;
      }
    }
  }
}

TEST(Bc4Encoder, MoreEffortNeverCostsQuality) {
  auto images = scalar_images(64);
  Image16 first(64, 64), second(64, 64);
  const Image16 normals = normals_image(64, 1);
  for (std::size_t i = 0; i < first.samples.size(); ++i)
    first.samples[i] = normals.samples[i * 2], second.samples[i] = normals.samples[i * 2 + 1];
  images.push_back({"x of normals", first});
  images.push_back({"y of normals", second});
  for (const auto& [name, image] : images) {
    const std::vector<std::byte> fast = encoded(image, Quality::kFast), normal = encoded(image, Quality::kNormal),
                                 best = encoded(image, Quality::kBest);
    for (std::size_t i = 0; i < fast.size() / 8; ++i) {
      const Block16 texels = block_of(image, i);
      const auto error = [&](const std::vector<std::byte>& blocks) {
        return static_cast<double>(error_in_parts(texels, std::span(blocks).subspan(i * 8, 8)));
      };
      // Every block, to the float rounding of the comparison.
      ASSERT_LE(error(normal), error(fast) * (1 + 1e-5)) << name << ", block " << i;
      ASSERT_LE(error(best), error(normal) * (1 + 1e-5)) << name << ", block " << i;
    }
  }
}

TEST(Bc4Encoder, FlatBlocksOfCodesAreExact) {
  Image16 image(4 * 256, 4);
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < image.width; ++x) image.at(x, y) = static_cast<std::uint16_t>(x / 4 * 257);
  for (const Quality quality : kQualities) EXPECT_EQ(mean_squared_error(image, encoded(image, quality)), 0.0);
}

TEST(Bc4Encoder, TwoCodesInAnyPatternAreExact) {
  std::mt19937 random(4);
  Image16 image(256, 256);
  for (std::size_t block = 0; block < 64 * 64; ++block) {
    // Alternating black and white first.
    const auto first = static_cast<std::uint16_t>(block < 16 ? 0 : random() % 256 * 257);
    const auto second = static_cast<std::uint16_t>(block < 16 ? 65535 : random() % 256 * 257);
    for (std::size_t i = 0; i < 16; ++i)
      image.at(block % 64 * 4 + i % 4, block / 64 * 4 + i / 4) = (block < 8 ? (i + i / 4) % 2 == 0 : random() % 2 == 0) ? first : second;
  }
  for (const Quality quality : kQualities) EXPECT_EQ(mean_squared_error(image, encoded(image, quality)), 0.0);
}

TEST(Bc4Encoder, ZeroAnd255BesideANarrowMiddleUseTheModeOfSixValues) {
  // Middle values on the fifths of a pair of codes: six values hold the block exactly, eight cannot.
  std::mt19937 random(8);
  Image16 image(4 * 200, 4);
  for (std::size_t block = 0; block < 200; ++block) {
    const auto low = static_cast<int>(40 + random() % 150), high = low + 5 + static_cast<int>(random() % 4) * 5;
    for (std::size_t i = 0; i < 16; ++i) {
      const auto k = static_cast<int>(random() % 8);
      const int code = i == 0   ? low
                       : i == 1 ? high
                       : i == 2 ? 0
                       : i == 3 ? 255
                       : k == 6 ? 0
                       : k == 7 ? 255
                                : low + (high - low) * std::min(k, 5) / 5;
      image.at(block * 4 + i % 4, i / 4) = static_cast<std::uint16_t>(code * 257);
    }
  }
  for (const Quality quality : {Quality::kNormal, Quality::kBest}) {
    const std::vector<std::byte> blocks = encoded(image, quality);
    EXPECT_EQ(mean_squared_error(image, blocks), 0.0);
    for (std::size_t i = 0; i < blocks.size(); i += 8) EXPECT_LE(blocks[i], blocks[i + 1]);
  }
}

TEST(Bc4Encoder, LinearRampsStayWithinHalfAStep) {
  // Samples between the extremes are at most half a seventh of the range away from a value between the
  // unrounded extremes; rounding an end point moves the values by at most half a code.
  for (const double range : {2.0, 7.0, 30.0, 100.0, 250.0}) {
    Image16 image(4, 4);
    for (std::size_t i = 0; i < 16; ++i)
      image.samples[i] = static_cast<std::uint16_t>(std::lround((2.3 + range * static_cast<double>(i) / 15) * 257));
    const std::vector<std::byte> block = encoded(image, Quality::kFast);
    const auto values = store::decode_bc4_block(std::span(block).first<8>());
    for (std::size_t i = 0; i < 16; ++i) EXPECT_LE(std::abs(values[i] - image.samples[i] / 257.0), range / 14 + 0.5) << range;
  }
}

TEST(Bc4Encoder, EveryTargetMakesTheSameBytes) {
  ASSERT_FALSE(targets().empty());
  for (const Quality quality : kQualities) {
    for (const auto& [name, image] : scalar_images(quality == Quality::kBest ? 32 : 128)) {
      std::vector<std::byte> expected;
      for (const std::int64_t target : targets()) {
        const ForcedTarget forced(target);
        const std::vector<std::byte> blocks = encoded(image, quality);
        if (expected.empty()) expected = blocks;
        EXPECT_EQ(blocks, expected) << name << " on " << hwy::TargetName(target);
      }
    }
  }
}

TEST(Bc4Encoder, WidthAlignmentPitchAndNeighboursDoNotMatter) {
  const Image16 wide = scalar_images(4 * 36)[5].image;
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> together = encoded(wide, quality);
    for (std::size_t width = 4; width <= 4 * 35; width += quality == Quality::kBest ? 44 : 4) {
      // Cut to exact size, so that a sanitizer sees a read past the last texel; an odd start and an odd
      // pitch.
      const std::size_t pitch = width * 2 + 13;
      std::vector<std::byte> bytes(1 + 7 * pitch + width * 2, std::byte{0xA5});
      for (std::size_t y = 0; y < 8; ++y) std::memcpy(&bytes[1 + y * pitch], &wide.samples[y * wide.width], width * 2);
      std::vector<std::byte> blocks(width * 8 / 2 + 1, std::byte{0x5A});
      encode_bc4_image(std::span(bytes).subspan(1), width, 8, pitch, quality, std::span(blocks).first(blocks.size() - 1));
      for (std::size_t row = 0; row < 2; ++row)
        ASSERT_TRUE(std::equal(&blocks[row * width * 2], &blocks[row * width * 2] + width * 2, &together[row * wide.width * 2])) << width;
      ASSERT_EQ(blocks.back(), std::byte{0x5A});
    }
  }
}

TEST(Bc5Encoder, IsTwoBc4BlocksSideBySide) {
  const Image16 image = normals_image(4 * 19, 2);
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> blocks = encoded(image, quality);
    for (std::size_t c = 0; c < 2; ++c) {
      Image16 channel(image.width, image.height);
      for (std::size_t i = 0; i < channel.samples.size(); ++i) channel.samples[i] = image.samples[i * 2 + c];
      const std::vector<std::byte> alone = encoded(channel, quality);
      for (std::size_t i = 0; i < alone.size(); ++i) ASSERT_EQ(alone[i], blocks[i / 8 * 16 + c * 8 + i % 8]);
    }
  }
}

TEST(Bc4Encoder, NotWorseThanStbOrLibsquish) {
  auto images = scalar_images(128);
  images.push_back({"normals", normals_image(128, 1)});
  for (const auto& [name, image] : images) {
    const double ours = mean_squared_error(image, encoded(image, Quality::kNormal));
    EXPECT_LE(ours, mean_squared_error(image, encoded_by_stb(image))) << name;
    EXPECT_LE(ours, mean_squared_error(image, encoded_by_squish(image))) << name;
  }
}

}  // namespace
}  // namespace vt::encode
