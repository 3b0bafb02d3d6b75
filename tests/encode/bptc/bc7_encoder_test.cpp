#include "builder/encode/bptc/bc7_encoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "store/texel/bc7.h"
#include "store/texel/bptc_table.h"
#include "tests/encode/bptc/bc7_definition.h"
#include "tests/encode/bptc/bc7_images.h"
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

// Noise, photographs, flat and nearly flat blocks, two and three colours, ramps, with and without alpha:
// everything that takes another way through the encoder.
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
  // A ramp from v to v + range in 16 steps, in the colours and in alpha: the 16 positions of mode 6 hit each
  // step, to the rounding of the weights (1/128 of the range), of the ramp itself (1/2), of the decoder
  // (1/2), and of the codes (1, since both ends share their lowest bit between the channels).
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
  // Mode 6 stores two colours with 7 bits and one lowest bit for all channels: each value is wrong by 1 at
  // most.
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

// Squared error of a plain encoder of mode 6: the longest distance between two texels for a start, then eight
// rounds of least squares in double, each end point rounded by itself with each pair of lowest bits (255
// needs both to be 1); the best round counts. Texels take the nearest position on the line.
int plain_mode6_error(const RgbaTexels& texels) {
  using Ends = std::array<std::array<double, 4>, 2>;
  const bool is_opaque = std::all_of(texels.begin(), texels.end(), [](const auto& texel) { return texel[3] == 255; });
  Ends ends{};
  int longest = -1;
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t j = i; j < 16; ++j) {
      int d2 = 0;
      for (std::size_t c = 0; c < 4; ++c) d2 += (texels[i][c] - texels[j][c]) * (texels[i][c] - texels[j][c]);
      if (d2 <= longest) continue;
      longest = d2;
      for (std::size_t c = 0; c < 4; ++c) ends[0][c] = texels[i][c], ends[1][c] = texels[j][c];
    }
  }
  const auto index_on = [](const Ends& line, const std::array<int, 4>& texel) {
    double nearest = 1e30;
    std::size_t index = 0;
    for (std::size_t k = 0; k < 16; ++k) {
      const double w = store::kWeights4[k] / 64.0;
      double d2 = 0;
      for (std::size_t c = 0; c < 4; ++c) d2 += std::pow(texel[c] - line[0][c] * (1 - w) - line[1][c] * w, 2);
      if (d2 < nearest) nearest = d2, index = k;
    }
    return index;
  };
  int best = 1 << 30;
  for (int round = 0; round < 8; ++round) {
    double aa = 0, ab = 0, bb = 0;
    std::array<double, 4> ax{}, bx{};
    for (const auto& texel : texels) {
      const double b = store::kWeights4[index_on(ends, texel)] / 64.0, a = 1.0 - b;
      aa += a * a, ab += a * b, bb += b * b;
      for (std::size_t c = 0; c < 4; ++c) ax[c] += a * texel[c], bx[c] += b * texel[c];
    }
    const double determinant = aa * bb - ab * ab;
    if (determinant < 1e-9) break;
    for (std::size_t c = 0; c < 4; ++c) {
      ends[0][c] = (ax[c] * bb - bx[c] * ab) / determinant;
      ends[1][c] = (bx[c] * aa - ax[c] * ab) / determinant;
    }
    for (int lowest = is_opaque ? 3 : 0; lowest < 4; ++lowest) {
      Ends codes{};
      for (std::size_t end = 0; end < 2; ++end) {
        const int bit = lowest >> end & 1;
        for (std::size_t c = 0; c < 4; ++c)
          codes[end][c] = std::clamp(static_cast<int>(std::lround((ends[end][c] - bit) / 2)), 0, 127) * 2 + bit;
      }
      int error = 0;
      for (const auto& texel : texels) {
        const int w = store::kWeights4[index_on(codes, texel)];
        for (std::size_t c = 0; c < 4; ++c) {
          const int decoded = (static_cast<int>(codes[0][c]) * (64 - w) + static_cast<int>(codes[1][c]) * w + 32) / 64;
          error += (decoded - texel[c]) * (decoded - texel[c]);
        }
      }
      best = std::min(best, error);
    }
  }
  return best;
}

double total(const std::vector<int>& errors) { return std::accumulate(errors.begin(), errors.end(), 0.0); }

TEST(Bc7Encoder, EvenFastIsAboutPlainLeastSquaresInModeSix) {
  // The plain encoder tries four times as many lowest bits and four times as many rounds: 2 % of squared
  // error, 0.1 dB, is what that may buy.
  for (const RgbaImage& image : {RgbaImage(photographic_image(256, 256, 1)), photographic_alpha_image(256, 256, 1)}) {
    double plain = 0;
    for (std::size_t i = 0; i < image.width * image.height / 16; ++i) plain += plain_mode6_error(block_texels(image, i));
    EXPECT_LE(total(bc7_block_errors(image, encoded_bc7(image, Quality::kFast))), 1.02 * plain);
    EXPECT_LE(total(bc7_block_errors(image, encoded_bc7(image, Quality::kNormal))), 0.8 * plain);
  }
}

TEST(Bc7Encoder, QualityOnPhotographs) {
  // What it reaches, less 0.1 dB: a change that loses more is a fault. The second picture has half the
  // contrast of the first, as plain country has it.
  Image picture = photographic_image(512, 512, 1);
  const auto reached = [&](Quality quality) {
    const RgbaImage image(picture);
    return bc7_psnr_db(image, encoded_bc7(image, quality), 3);
  };
  EXPECT_GT(reached(Quality::kFast), 44.2);
  EXPECT_GT(reached(Quality::kNormal), 47.9);
  EXPECT_GT(reached(Quality::kBest), 48.3);
  for (std::byte& value : picture.rgb) value = static_cast<std::byte>(std::to_integer<int>(value) / 2 + 64);
  EXPECT_GT(reached(Quality::kFast), 48.0);
}

TEST(Bc7Encoder, EveryModeIsUsed) {
  // Each one earns its place somewhere; a mode that never wins is a fault in it.
  std::set<int> modes;
  for (const RgbaImage& image : {hostile_image(), RgbaImage(photographic_image(256, 256, 1)), photographic_alpha_image(256, 256, 1)}) {
    const std::vector<std::byte> blocks = encoded_bc7(image, Quality::kBest);
    for (std::size_t i = 0; i < blocks.size(); i += 16) modes.insert(std::countr_zero(std::to_integer<unsigned>(blocks[i])));
  }
  EXPECT_EQ(modes, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(Bc7Encoder, RealImagery) {
  int found = 0;
  for (const char* name : kRealImages) {
    const std::optional<Image> picture = real_image(name);
    if (!picture) continue;
    ++found;
    const RgbaImage image(*picture);
    std::array<double, 3> db{};
    for (std::size_t q = 0; q < 3; ++q) db[q] = bc7_psnr_db(image, encoded_bc7(image, kQualities[q]), 3);
    // BC1 stores half as much; one subset of BC7 is never behind it, and two subsets are well ahead.
    const double bc1 = psnr_db(mean_squared_error(*picture, encoded(*picture)));
    EXPECT_GT(db[0], bc1) << name;
    EXPECT_GT(db[1], db[0] + 1.0) << name;
    EXPECT_GE(db[2], db[1]) << name;
    RecordProperty(name, std::to_string(db[0]) + " " + std::to_string(db[1]) + " " + std::to_string(db[2]) + " dB");
  }
  if (found == 0) GTEST_SKIP() << "no real imagery: set VT_TEST_DATA to the folder that holds it";
}

}  // namespace
}  // namespace vt::encode
