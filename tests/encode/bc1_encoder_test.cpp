#include "builder/encode/bc1_encoder.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "store/bc1.h"

namespace vt::encode {
namespace {

struct Image {
  std::size_t width;
  std::size_t height;
  std::vector<std::byte> rgb;

  Image(std::size_t w, std::size_t h) : width(w), height(h), rgb(w * h * 3) {}
  void set(std::size_t x, std::size_t y, std::array<int, 3> color) {
    for (std::size_t c = 0; c < 3; ++c) rgb[(y * width + x) * 3 + c] = static_cast<std::byte>(color[c]);
  }
  int get(std::size_t x, std::size_t y, std::size_t c) const { return std::to_integer<int>(rgb[(y * width + x) * 3 + c]); }
};

std::vector<std::byte> encoded(const Image& image) {
  std::vector<std::byte> blocks(image.width * image.height / 2);
  encode_bc1_image(image.rgb, image.width, image.height, image.width * 3, 3, blocks);
  return blocks;
}

// Sum of squared differences of each block.
std::vector<int> block_errors(const Image& image, const std::vector<std::byte>& blocks) {
  std::vector<int> errors;
  for (std::size_t y = 0; y < image.height; y += 4) {
    for (std::size_t x = 0; x < image.width; x += 4) {
      const auto texels = store::decode_bc1_block(std::span(blocks).subspan(errors.size() * 8).first<8>());
      int error = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          const int d = texels[i][c] - image.get(x + i % 4, y + i / 4, c);
          error += d * d;
        }
      }
      errors.push_back(error);
    }
  }
  return errors;
}

bool is_four_color(std::span<const std::byte> block) {
  const int color0 = std::to_integer<int>(block[0]) | std::to_integer<int>(block[1]) << 8;
  const int color1 = std::to_integer<int>(block[2]) | std::to_integer<int>(block[3]) << 8;
  return color0 > color1;
}

Image noise_image(std::size_t width, std::size_t height, unsigned seed) {
  Image image(width, height);
  std::mt19937 random(seed);
  for (std::byte& value : image.rgb) value = static_cast<std::byte>(random());
  return image;
}

TEST(Bc1Encoder, EveryBlockIsInTheFourColorMode) {
  Image image = noise_image(256, 64, 1);
  // A third of the blocks flat, a third nearly flat, black and white among them.
  std::mt19937 random(2);
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t x = 0; x < image.width; ++x) {
      const std::size_t block = y / 4 * 64 + x / 4;
      const int base = block % 7 == 0 ? 0 : block % 7 == 1 ? 255 : static_cast<int>(block * 37 % 256);
      if (block % 3 == 0) image.set(x, y, {base, base, base});
      if (block % 3 == 1) image.set(x, y, {base, std::min(255, base + static_cast<int>(random() % 2)), base});
    }
  }
  const std::vector<std::byte> blocks = encoded(image);
  for (std::size_t i = 0; i < blocks.size(); i += 8) ASSERT_TRUE(is_four_color(std::span(blocks).subspan(i, 8))) << "block " << i / 8;
}

// The least error of one channel over all pairs of codes and all indices, by trying them all.
std::array<int, 256> least_errors(int bits) {
  std::array<int, 256> least;
  least.fill(255);
  const int codes = 1 << bits;
  const auto expand = [bits](int code) { return bits == 5 ? code * 8 + code / 4 : code * 4 + code / 16; };
  for (int v = 0; v < 256; ++v) {
    for (int e0 = 0; e0 < codes; ++e0) {
      for (int e1 = 0; e1 < codes; ++e1) {
        const int a = expand(e0), b = expand(e1);
        for (const int value : {a, b, (2 * a + b + 1) / 3, (a + 2 * b + 1) / 3}) least[v] = std::min(least[v], std::abs(value - v));
      }
    }
  }
  return least;
}

TEST(Bc1Encoder, FlatBlocksHaveTheLeastPossibleError) {
  const std::array<int, 256> least5 = least_errors(5);
  const std::array<int, 256> least6 = least_errors(6);
  // Every value in every channel, with the others at 0, at 255, equal, and anywhere.
  std::vector<std::array<int, 3>> colors;
  std::mt19937 random(3);
  for (int v = 0; v < 256; ++v) {
    const int p = static_cast<int>(random() % 256), q = static_cast<int>(random() % 256);
    for (const std::array<int, 3>& color : {std::array{v, 0, 0},
                                            {0, v, 0},
                                            {0, 0, v},
                                            {v, 255, 255},
                                            {255, v, 255},
                                            {255, 255, v},
                                            {v, v, v},
                                            {v, p, q},
                                            {p, v, q},
                                            {p, q, v}})
      colors.push_back(color);
  }
  Image image(colors.size() * 4, 4);
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < image.width; ++x) image.set(x, y, colors[x / 4]);
  const std::vector<std::byte> blocks = encoded(image);
  const std::vector<int> errors = block_errors(image, blocks);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const auto [r, g, b] = colors[i];
    const int least = least5[r] * least5[r] + least6[g] * least6[g] + least5[b] * least5[b];
    ASSERT_EQ(errors[i], 16 * least) << r << " " << g << " " << b;
    ASSERT_TRUE(is_four_color(std::span(blocks).subspan(i * 8, 8)));
  }
}

TEST(Bc1Encoder, AllTargetsMakeTheSameBytes) {
  const Image image = noise_image(4 * 37, 64, 9);
  std::vector<std::byte> first;
  int targets = 0;
  const std::int64_t supported = hwy::SupportedTargets();
  for (const std::int64_t target : {HWY_EMU128, HWY_SCALAR, HWY_SSSE3, HWY_SSE4, HWY_AVX2, HWY_AVX3, HWY_AVX3_DL, HWY_NEON}) {
    if ((supported & HWY_TARGETS & target) == 0) continue;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const std::vector<std::byte> blocks = encoded(image);
    if (targets++ == 0) first = blocks;
    EXPECT_EQ(blocks, first) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GE(targets, 1);
}

}  // namespace
}  // namespace vt::encode
