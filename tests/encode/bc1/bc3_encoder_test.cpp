#include "builder/encode/bc1/bc3_encoder.h"

#include <gtest/gtest.h>
#include <squish.h>

#include <algorithm>
#include <random>

#include "builder/encode/bc4/bc4_encoder.h"
#include "store/texel/bc3.h"
#include "tests/encode/bc1/bc1_images.h"
#include "tests/encode/simd_targets.h"

namespace vt::encode {
namespace {

constexpr Quality kQualities[] = {Quality::kFast, Quality::kNormal, Quality::kBest};

// RGBA, tightly packed: a photograph whose alpha is chosen per texel.
struct Rgba {
  std::size_t width, height;
  std::vector<std::byte> bytes;
  template <class Alpha>
  Rgba(const Image& image, const Alpha& alpha) : width(image.width), height(image.height) {
    for (std::size_t i = 0; i < width * height; ++i) {
      bytes.insert(bytes.end(), &image.rgb[i * 3], &image.rgb[i * 3] + 3);
      bytes.push_back(static_cast<std::byte>(alpha(i)));
    }
  }
};

std::vector<std::byte> encoded(const Rgba& image, Quality quality) {
  std::vector<std::byte> blocks(image.width * image.height);
  encode_bc3_image(image.bytes, image.width, image.height, image.width * 4, quality, blocks);
  return blocks;
}

// Holes with soft edges: alpha 0, 255 and between.
Rgba soft_holes(std::size_t edge, unsigned seed) {
  std::mt19937 random(seed);
  return {photographic_image(edge, edge, seed), [&](std::size_t i) -> unsigned {
            const auto kind = (i % edge / 4 + i / edge / 4 * 7) % 5;  // by block
            if (kind == 0) return 255U;
            if (kind == 1) return 0U;
            return kind == 2 ? static_cast<unsigned>(random() % 2 * 255) : static_cast<unsigned>(random() % 256 * (random() % 2));
          }};
}

TEST(Bc3Encoder, ColorsUnderAlphaZeroDoNotChangeTheBlock) {
  const Rgba image = soft_holes(128, 1);
  Rgba other = image;
  std::mt19937 random(2);
  std::vector<bool> has_visible(image.width * image.height / 16);
  const auto block_of_texel = [&](std::size_t i) { return i / image.width / 4 * (image.width / 4) + i % image.width / 4; };
  for (std::size_t i = 0; i < image.width * image.height; ++i) {
    if (image.bytes[i * 4 + 3] != std::byte{0}) {
      has_visible[block_of_texel(i)] = true;
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) other.bytes[i * 4 + c] = static_cast<std::byte>(random());
  }
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> expected = encoded(image, quality), blocks = encoded(other, quality);
    for (std::size_t i = 0; i < blocks.size(); i += 16) {
      if (has_visible[i / 16]) {
        ASSERT_TRUE(std::equal(&blocks[i], &blocks[i] + 16, &expected[i])) << "block " << i / 16;
      }
    }
  }
}

TEST(Bc3Encoder, OpaqueAndWhollyTransparentBlocksHaveTheColorsOfBc1) {
  const Image picture = photographic_image(64, 64, 3);
  for (const unsigned alpha : {0U, 1U, 255U}) {
    const Rgba image(picture, [&](std::size_t) { return alpha; });
    const std::vector<std::byte> blocks = encoded(image, Quality::kNormal), colors = vt::encode::encoded(picture);
    for (std::size_t i = 0; i < colors.size(); ++i) ASSERT_EQ(blocks[i / 8 * 16 + 8 + i % 8], colors[i]) << "alpha " << alpha;
    for (std::size_t i = 0; i < blocks.size(); i += 16)
      for (const auto& texel : store::decode_bc3_block(std::span(blocks).subspan(i).first<16>())) ASSERT_EQ(texel[3], alpha);
  }
}

TEST(Bc3Encoder, FewVisibleTexelsAreFittedAsIfTheyWereTheWholeBlock) {
  // Two colours that 5:6:5 holds exactly are exact, whatever lies under the transparent texels and however
  // few are visible.
  std::mt19937 random(4);
  Image picture(4 * 512, 4);
  std::vector<unsigned> alpha(picture.width * 4);
  for (std::size_t block = 0; block < 512; ++block) {
    const auto code = [&](int bits) {
      const int value = static_cast<int>(random() % (1U << bits));
      return bits == 5 ? value * 8 + value / 4 : value * 4 + value / 16;
    };
    const std::array<int, 3> first{code(5), code(6), code(5)}, second{code(5), code(6), code(5)};
    for (std::size_t i = 0; i < 16; ++i) {
      const std::size_t x = block * 4 + i % 4;
      const bool visible = i == block % 16 || random() % 4 == 0;
      alpha[i / 4 * picture.width + x] = visible ? 1 + random() % 255 : 0;
      const int noise = static_cast<int>(random() % 256);
      picture.set(x, i / 4, !visible ? std::array{noise, 255 - noise, 0} : random() % 2 == 0 ? first : second);
    }
  }
  const Rgba image(picture, [&](std::size_t i) { return alpha[i]; });
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> blocks = encoded(image, quality);
    std::vector<std::byte> decoded(image.bytes.size());
    store::decode_bc3_image(blocks, image.width, image.height, decoded);
    for (std::size_t i = 0; i < decoded.size(); ++i) {
      if (i % 4 != 3 && alpha[i / 4] > 0) {
        ASSERT_EQ(decoded[i], image.bytes[i]) << "byte " << i;
      }
    }
  }
}

TEST(Bc3Encoder, EveryTargetMakesTheSameBytesAndWidthPitchAndNeighboursDoNotMatter) {
  const Rgba image = soft_holes(4 * 35, 5);
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> together = encoded(image, quality);
    for (const std::int64_t target : targets()) {
      const ForcedTarget forced(target);
      ASSERT_EQ(encoded(image, quality), together) << hwy::TargetName(target);
    }
    for (std::size_t width = 4; width <= image.width; width += quality == Quality::kBest ? 36 : 4) {
      const std::size_t pitch = width * 4 + 13;
      std::vector<std::byte> bytes(1 + 3 * pitch + width * 4, std::byte{0xA5});
      for (std::size_t y = 0; y < 4; ++y) std::copy_n(&image.bytes[y * image.width * 4], width * 4, &bytes[1 + y * pitch]);
      std::vector<std::byte> blocks(width * 4);
      encode_bc3_image(std::span(bytes).subspan(1), width, 4, pitch, quality, blocks);
      ASSERT_TRUE(std::equal(blocks.begin(), blocks.end(), together.begin())) << width;
    }
  }
}

TEST(Bc3Encoder, LibsquishDecodesTheSameTexels) {
  const Rgba image = soft_holes(64, 6);
  for (const Quality quality : kQualities) {
    const std::vector<std::byte> blocks = encoded(image, quality);
    for (std::size_t i = 0; i < blocks.size(); i += 16) {
      const auto ours = store::decode_bc3_block(std::span(blocks).subspan(i).first<16>());
      std::array<squish::u8, 64> theirs{};
      squish::Decompress(theirs.data(), &blocks[i], squish::kDxt5);
      // It drops the fraction where we round: one code at most.
      for (std::size_t t = 0; t < 64; ++t) ASSERT_NEAR(int{ours[t / 4][t % 4]}, int{theirs[t]}, 1) << "block " << i / 16;
    }
  }
}

}  // namespace
}  // namespace vt::encode
