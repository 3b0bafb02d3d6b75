#include "builder/encode/bptc/bc6h_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "store/texel/bc6h.h"
#include "tests/encode/bptc/bc6h_definition.h"
#include "tests/encode/bptc/bc6h_images.h"
#include "tests/encode/simd_targets.h"

namespace vt::encode {
namespace {

constexpr std::array<Quality, 3> kQualities{Quality::kFast, Quality::kNormal, Quality::kBest};
constexpr std::uint16_t kLargestHalf = 0x7BFF;

HalfTexels block_texels(const HalfImage& image, std::size_t block) {
  const std::size_t x = block % (image.width / 4) * 4;
  const std::size_t y = block / (image.width / 4) * 4;
  HalfTexels texels{};
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t c = 0; c < 3; ++c) texels[i][c] = image.rgba[((y + i / 4) * image.width + x + i % 4) * 4 + c];
  return texels;
}

// Any bits (NaN, infinities, negative numbers among them), subnormals, smooth and wide ranges, one hot texel
// in the dark, flat blocks.
HalfImage hostile_image() {
  HalfImage image(4 * 37, 4 * 48);
  std::mt19937 random(7);
  const auto code = [&](unsigned from, unsigned count) { return static_cast<std::uint16_t>(from + random() % count); };
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto kind = random() % 9;
      const unsigned base = code(0, 0x7000), spread = 1U << (random() % 13);
      std::array<std::uint16_t, 3> color{};
      for (std::uint16_t& value : color) value = code(0, 0x7C00);
      const std::size_t hot = random() % 16;
      for (std::size_t i = 0; i < 16; ++i) {
        std::uint16_t* const texel = &image.rgba[((y + i / 4) * image.width + x + i % 4) * 4];
        for (std::size_t c = 0; c < 3; ++c) {
          if (kind == 0) texel[c] = static_cast<std::uint16_t>(random());
          if (kind == 1) texel[c] = color[c];
          if (kind == 2) texel[c] = code(0, 1024);
          if (kind == 3) texel[c] = code(base, std::min(spread, 0x7C00U - base));
          if (kind == 4) texel[c] = i == hot ? kLargestHalf : code(0x1000, 64);
          if (kind == 5) texel[c] = random() % 2 == 0 ? color[c] : color[(c + 1) % 3];
          if (kind == 6) texel[c] = static_cast<std::uint16_t>(base + i * spread / 64 + c);
          if (kind == 7) texel[c] = random() % 4 == 0 ? 0x7C00 : random() % 3 == 0 ? 0x7E00 : random() % 2 == 0 ? 0xFC00 : color[c];
          if (kind == 8) texel[c] = 0;
        }
      }
    }
  }
  return image;
}

// What the encoder's header says the source counts as.
HalfImage storable(HalfImage image) {
  for (std::uint16_t& half : image.rgba) {
    if (half == 0x7C00) half = kLargestHalf;
    if (half > 0x7C00) half = 0;
  }
  return image;
}

TEST(Bc6hEncoder, EveryTargetMakesTheBytesOfTheDefinition) {
  const HalfImage image = hostile_image();
  ASSERT_FALSE(targets().empty());
  for (const Quality quality : kQualities) {
    std::vector<std::byte> defined;
    for (std::size_t i = 0; i < image.width * image.height / 16; ++i) {
      const auto block = encode_bc6h_block_by_definition(block_texels(image, i), quality);
      defined.insert(defined.end(), block.begin(), block.end());
    }
    for (const std::int64_t target : targets()) {
      const ForcedTarget forced(target);
      const std::vector<std::byte> blocks = encoded_bc6h(image, quality);
      std::size_t different = 0;
      for (std::size_t i = 0; i < blocks.size(); i += 16) different += std::equal(&blocks[i], &blocks[i] + 16, &defined[i]) ? 0U : 1U;
      EXPECT_EQ(different, 0U) << hwy::TargetName(target) << " quality " << static_cast<int>(quality) << ", of " << blocks.size() / 16;
    }
  }
}

TEST(Bc6hEncoder, OneColorIsExactForEveryHalf) {
  // Every finite half that is not negative, in each channel, beside two others anywhere.
  HalfImage image(4 * 0x7C00, 4);
  std::mt19937 random(3);
  for (std::size_t block = 0; block < 0x7C00; ++block) {
    std::array<std::uint16_t, 3> color{};
    for (std::uint16_t& value : color) value = static_cast<std::uint16_t>(random() % 0x7C00);
    color[block % 3] = static_cast<std::uint16_t>(block);
    for (std::size_t i = 0; i < 16; ++i)
      for (std::size_t c = 0; c < 3; ++c) image.rgba[(i / 4 * image.width + block * 4 + i % 4) * 4 + c] = color[c];
  }
  for (const Quality quality : kQualities)
    for (const double error : bc6h_block_errors(image, encoded_bc6h(image, quality))) ASSERT_EQ(error, 0);
}

TEST(Bc6hEncoder, WhatCannotBeStoredIsTheNearestThatCan) {
  HalfImage image(16, 4);
  constexpr std::array<std::uint16_t, 4> kHalves{0x7C00, 0xFC00, 0x7E01, 0xC000};
  constexpr std::array<std::uint16_t, 4> kStored{kLargestHalf, 0, 0, 0};
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 16; ++x)
      for (std::size_t c = 0; c < 3; ++c) image.rgba[(y * 16 + x) * 4 + c] = kHalves[x / 4];
  const std::vector<std::byte> blocks = encoded_bc6h(image, Quality::kNormal);
  for (std::size_t block = 0; block < 4; ++block)
    for (const auto& texel : store::decode_bc6h_block(std::span(blocks).subspan(block * 16).first<16>()))
      for (const std::uint16_t half : texel) EXPECT_EQ(half, kStored[block]);
}

TEST(Bc6hEncoder, LightIsKept) {
  // The sum of light of every channel over a picture. What is left is the rounding of codes, which has no
  // preferred direction.
  for (const Quality quality : kQualities) {
    for (const HalfImage& image : {day_image(256, 256, 1), night_image(512, 512, 1), noise_half_image(256, 256, 1, 1)}) {
      for (const double ratio : light_ratios(image, encoded_bc6h(image, quality))) {
        EXPECT_NEAR(ratio, 1.0, 0.001) << "quality " << static_cast<int>(quality);
      }
    }
  }
}

TEST(Bc6hEncoder, AHotTexelInTheDarkKeepsBoth) {
  // A fire of any strength on dark ground, in one block: where they are more than four octaves apart only the
  // mode with 10 bits for each end holds both. Its codes are 64 * 31 / 64 = 31 half codes apart, so the
  // nearest is within 16 (half for the decoder's fraction), and the source is rounded by a half, and a half
  // code is 1/1024 of a value at most.
  std::mt19937 random(8);
  for (int round = 0; round < 200; ++round) {
    HalfImage image(4, 4);
    const double dark = std::exp2(-static_cast<double>(random() % 12)), hot = std::exp2(1.0 + static_cast<double>(random() % 15)) * 0.97;
    const std::size_t at = random() % 16;
    for (std::size_t i = 0; i < 16; ++i) {
      const double light = i == at ? hot : dark;
      image.set(i % 4, i / 4, {light, light, light});
    }
    const auto texels = store::decode_bc6h_block(std::span<const std::byte>(encoded_bc6h(image, Quality::kNormal)).first<16>());
    for (std::size_t i = 0; i < 16; ++i)
      for (const std::uint16_t half : texels[i])
        EXPECT_NEAR(light_of(half) / (i == at ? hot : dark), 1.0, 16.5 / 1024.0) << dark << " " << hot;
  }
}

// It need not be true of blocks, and of pictures only nearly between the upper two: what is made small is not
// the squared error of codes alone, and of noise in which lines hardly help six partitions offer more light
// to keep than one.
TEST(Bc6hEncoder, NoPictureIsWorseAtAHigherQuality) {
  for (const HalfImage& source : {hostile_image(), night_image(256, 256, 2), noise_half_image(128, 128, 6, 2), city_lights(256, 256, 3)}) {
    const HalfImage image = storable(source);
    std::array<double, 3> errors{};
    for (std::size_t q = 0; q < 3; ++q) errors[q] = rms_octaves(image, encoded_bc6h(image, kQualities[q]));
    EXPECT_LE(errors[1], errors[0]);
    EXPECT_LE(errors[2], 1.005 * errors[1]);
  }
}

// Lamps in darkness on every level of a pyramid: the ends of a block have to reach from one to the other, so
// that each index is an octave or more from the next, and what a single block does to the light is percents.
// Light is kept to 0.1 % where there are 64 blocks to it, all channels together; one channel of them has a
// third of the numbers.
TEST(Bc6hEncoder, LightOfLampsInTheDarkIsKeptOnEveryLevelAndAtEveryQuality) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    HalfImage image = city_lights(512, 512, seed);
    for (; image.width >= 32; image = halved(image)) {
      for (const Quality quality : kQualities) {
        const std::vector<std::byte> blocks = encoded_bc6h(image, quality);
        double source = 0.0;
        double result = 0.0;
        std::vector<std::byte> decoded(image.rgba.size() * 2);
        store::decode_bc6h_image(blocks, image.width, image.height, decoded);
        for (std::size_t i = 0; i < image.rgba.size(); ++i) {
          if (i % 4 == 3) continue;
          source += light_of(image.rgba[i]);
          result += light_of(
              static_cast<std::uint16_t>(std::to_integer<unsigned>(decoded[2 * i]) | std::to_integer<unsigned>(decoded[2 * i + 1]) << 8U));
        }
        EXPECT_NEAR(result / source, 1.0, 0.001) << "quality " << static_cast<int>(quality) << ", " << image.width << ", seed " << seed;
      }
    }
  }
}

TEST(Bc6hEncoder, WidthAlignmentAndPitchDoNotMatter) {
  for (std::size_t width = 4; width <= 4 * 35; width += 4) {
    const HalfImage image = noise_half_image(width, 8, 4, static_cast<unsigned>(width));
    const std::vector<std::byte> expected = encoded_bc6h(image, Quality::kFast);
    // Cut to exact size, so that a sanitizer sees a read past the last texel; an odd start and an odd pitch.
    const std::size_t pitch = width * 8 + 13;
    std::vector<std::byte> bytes(1 + 7 * pitch + width * 8, std::byte{0xA5});
    for (std::size_t y = 0; y < 8; ++y)
      std::copy_n(image.bytes().begin() + static_cast<std::ptrdiff_t>(y * width * 8), width * 8,
                  bytes.begin() + static_cast<std::ptrdiff_t>(1 + y * pitch));
    std::vector<std::byte> blocks(expected.size() + 1, std::byte{0x5A});
    encode_bc6h_image(std::span(bytes).subspan(1), width, 8, pitch, Quality::kFast, std::span(blocks).first(expected.size()));
    ASSERT_TRUE(std::equal(expected.begin(), expected.end(), blocks.begin())) << width;
    ASSERT_EQ(blocks.back(), std::byte{0x5A});
  }
}

TEST(Bc6hEncoder, AlphaAndNeighboursDoNotChangeABlock) {
  HalfImage image = hostile_image();
  const std::vector<std::byte> together = encoded_bc6h(image, Quality::kBest);
  for (std::size_t i = 0; i < together.size() / 16; i += 17) {
    HalfImage alone(4, 4);
    const HalfTexels texels = block_texels(image, i);
    for (std::size_t t = 0; t < 16; ++t) {
      std::copy_n(texels[t].begin(), 3, &alone.rgba[t * 4]);
      alone.rgba[t * 4 + 3] = static_cast<std::uint16_t>(t * 4001);
    }
    const std::vector<std::byte> block = encoded_bc6h(alone, Quality::kBest);
    ASSERT_TRUE(std::equal(block.begin(), block.end(), &together[i * 16])) << "block " << i;
  }
}

}  // namespace
}  // namespace vt::encode
