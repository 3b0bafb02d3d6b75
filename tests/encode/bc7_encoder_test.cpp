#include "builder/encode/bc7_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "store/bc7.h"
#include "tests/encode/bc7_definition.h"
#include "tests/encode/bc7_images.h"
#include "tests/encode/simd_targets.h"

namespace vt::encode {
namespace {

constexpr std::array<Quality, 3> kQualities{Quality::kFast, Quality::kNormal, Quality::kBest};

RgbaTexels block_texels(const RgbaImage& image, std::size_t block) {
  const std::size_t x = block % (image.width / 4) * 4;
  const std::size_t y = block / (image.width / 4) * 4;
  RgbaTexels texels{};
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t c = 0; c < 4; ++c) texels[i][c] = image.get(x + i % 4, y + i / 4, c);
  return texels;
}

// Noise, photographs, flat and nearly flat blocks, two and three colours, ramps, with and without alpha: everything that takes another way
// through the encoder.
RgbaImage hostile_image() {
  RgbaImage image = photographic_alpha_image(4 * 37, 4 * 48, 3);
  std::mt19937 random(5);
  const auto any_color = [&]() -> std::array<int, 4> {
    return {static_cast<int>(random() % 256), static_cast<int>(random() % 256), static_cast<int>(random() % 256),
            static_cast<int>(random() % 256)};
  };
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto kind = random() % 8;
      const bool is_opaque = random() % 2 == 0;
      const std::array<int, 4> base = any_color(), other = any_color(), third = any_color();
      const int spread = 1 + static_cast<int>(random() % 4);
      for (std::size_t i = 0; i < 16; ++i) {
        const int k = static_cast<int>(i);
        const auto nudge = [&] { return static_cast<int>(random() % static_cast<unsigned>(spread)); };
        std::array<int, 4> color{};
        for (std::size_t c = 0; c < 4; ++c) color[c] = image.get(x + i % 4, y + i / 4, c);
        if (kind == 0) color = any_color();
        if (kind == 1) color = base;
        if (kind == 2) color = {base[0] + nudge(), base[1] + nudge(), base[2] + nudge(), base[3] + nudge()};
        if (kind == 3) color = random() % 2 == 0 ? base : other;
        if (kind == 4) color = {base[0] + k * spread, base[1] - k, base[2], base[3] + k};
        if (kind == 5) color = random() % 3 == 0 ? base : random() % 2 == 0 ? other : third;
        if (is_opaque) color[3] = 255;
        for (int& value : color) value = std::clamp(value, 0, 255);
        image.set(x + i % 4, y + i / 4, color);
      }
    }
  }
  return image;
}

TEST(Bc7Encoder, EveryTargetMakesTheBytesOfTheDefinition) {
  const RgbaImage image = hostile_image();
  ASSERT_FALSE(targets().empty());
  for (const Quality quality : kQualities) {
    std::vector<std::byte> defined;
    for (std::size_t i = 0; i < image.width * image.height / 16; ++i) {
      const auto block = encode_bc7_block_by_definition(block_texels(image, i), quality);
      defined.insert(defined.end(), block.begin(), block.end());
    }
    for (const std::int64_t target : targets()) {
      const ForcedTarget forced(target);
      const std::vector<std::byte> blocks = encoded_bc7(image, quality);
      std::size_t different = 0;
      for (std::size_t i = 0; i < blocks.size(); i += 16) different += std::equal(&blocks[i], &blocks[i] + 16, &defined[i]) ? 0U : 1U;
      EXPECT_EQ(different, 0U) << hwy::TargetName(target) << " quality " << static_cast<int>(quality) << ", of " << blocks.size() / 16;
    }
  }
}

TEST(Bc7Encoder, OneColorIsExact) {
  // Every value in every channel with the others anywhere.
  std::vector<std::array<int, 4>> colors;
  std::mt19937 random(3);
  for (int v = 0; v < 256; ++v) {
    for (std::size_t c = 0; c < 4; ++c) {
      std::array<int, 4> color{};
      for (int& value : color) value = static_cast<int>(random() % 256);
      color[c] = v;
      colors.push_back(color);
      color[3] = 255;
      colors.push_back(color);
    }
  }
  RgbaImage image(colors.size() * 4, 4);
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < image.width; ++x) image.set(x, y, colors[x / 4]);
  for (const Quality quality : kQualities)
    for (const int error : bc7_block_errors(image, encoded_bc7(image, quality))) ASSERT_EQ(error, 0);
}

TEST(Bc7Encoder, OpaqueStaysOpaque) {
  for (const Quality quality : kQualities) {
    for (const bool is_noise : {false, true}) {
      RgbaImage image = is_noise ? noise_rgba_image(256, 128, 1) : hostile_image();
      for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = std::byte{255};
      std::vector<std::byte> decoded(image.rgba.size());
      store::decode_bc7_image(encoded_bc7(image, quality), image.width, image.height, decoded);
      for (std::size_t i = 3; i < decoded.size(); i += 4) ASSERT_EQ(decoded[i], std::byte{255});
    }
  }
}

TEST(Bc7Encoder, NoBlockIsWorseAtAHigherQuality) {
  for (const RgbaImage& image : {hostile_image(), noise_rgba_image(128, 128, 2), photographic_alpha_image(256, 256, 4)}) {
    std::array<std::vector<int>, 3> errors;
    for (std::size_t q = 0; q < 3; ++q) errors[q] = bc7_block_errors(image, encoded_bc7(image, kQualities[q]));
    for (std::size_t i = 0; i < errors[0].size(); ++i) {
      ASSERT_LE(errors[1][i], errors[0][i]) << "block " << i;
      ASSERT_LE(errors[2][i], errors[1][i]) << "block " << i;
    }
  }
}

TEST(Bc7Encoder, WidthAlignmentAndPitchDoNotMatter) {
  for (std::size_t width = 4; width <= 4 * 35; width += 4) {
    const RgbaImage image = noise_rgba_image(width, 8, static_cast<unsigned>(width));
    const std::vector<std::byte> expected = encoded_bc7(image, Quality::kFast);
    // Cut to exact size, so that a sanitizer sees a read past the last texel; an odd start and an odd pitch.
    const std::size_t pitch = width * 4 + 13;
    std::vector<std::byte> bytes(1 + 7 * pitch + width * 4, std::byte{0xA5});
    for (std::size_t y = 0; y < 8; ++y)
      std::copy_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(y * width * 4), width * 4,
                  bytes.begin() + static_cast<std::ptrdiff_t>(1 + y * pitch));
    std::vector<std::byte> blocks(expected.size() + 1, std::byte{0x5A});
    encode_bc7_image(std::span(bytes).subspan(1), width, 8, pitch, Quality::kFast, std::span(blocks).first(expected.size()));
    ASSERT_TRUE(std::equal(expected.begin(), expected.end(), blocks.begin())) << width;
    ASSERT_EQ(blocks.back(), std::byte{0x5A});
  }
}

TEST(Bc7Encoder, NeighboursDoNotChangeABlock) {
  const RgbaImage image = hostile_image();
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> together = encoded_bc7(image, quality);
    for (std::size_t i = 0; i < together.size() / 16; i += 17) {
      RgbaImage alone(4, 4);
      const RgbaTexels texels = block_texels(image, i);
      for (std::size_t t = 0; t < 16; ++t) alone.set(t % 4, t / 4, texels[t]);
      const std::vector<std::byte> block = encoded_bc7(alone, quality);
      ASSERT_TRUE(std::equal(block.begin(), block.end(), &together[i * 16])) << "block " << i;
    }
  }
}

TEST(Bc7Encoder, GradientsStayNearTheIdealOfSixteenSteps) {
  // A ramp from v to v + range in 16 steps, in the colours and in alpha: the 16 positions of mode 6 hit each step, to the rounding of the
  // weights (1/128 of the range), of the ramp itself (1/2), of the decoder (1/2), and of the codes (1, since both ends share their lowest
  // bit between the channels).
  for (const int range : {15, 30, 60, 120, 240}) {
    RgbaImage image(8, 4);
    for (std::size_t i = 0; i < 16; ++i) {
      const int v = 8 + range * static_cast<int>(i) / 15;
      image.set(i % 4, i / 4, {v, v, v, 255});
      image.set(4 + i % 4, i / 4, {v, 255 - v, v, 8 + range - v + 8});
    }
    const double largest = range / 128.0 + 2.0;
    for (const Quality quality : kQualities)
      for (const int error : bc7_block_errors(image, encoded_bc7(image, quality))) EXPECT_LE(error, 64 * largest * largest) << range;
  }
}

TEST(Bc7Encoder, TwoColorsAreWithinTheRoundingOfTheirCodes) {
  // Mode 6 stores two colours with 7 bits and one lowest bit for all channels: each value is wrong by 1 at most.
  std::mt19937 random(6);
  RgbaImage image(4 * 512, 4);
  for (std::size_t block = 0; block < 512; ++block) {
    const auto color = [&]() -> std::array<int, 4> {
      return {static_cast<int>(random() % 256), static_cast<int>(random() % 256), static_cast<int>(random() % 256),
              block % 2 == 0 ? 255 : static_cast<int>(random() % 256)};
    };
    const std::array<int, 4> first = color(), second = color();
    for (std::size_t i = 0; i < 16; ++i) image.set(block * 4 + i % 4, i / 4, i == 0 || random() % 2 == 0 ? first : second);
  }
  for (const Quality quality : kQualities)
    for (const int error : bc7_block_errors(image, encoded_bc7(image, quality))) ASSERT_LE(error, 64);
}

}  // namespace
}  // namespace vt::encode
