#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "store/texel/bc1.h"
#include "store/texel/bc3.h"
#include "store/texel/bc4.h"

namespace vt::store {
namespace {

using Block = std::array<std::byte, 8>;

Block block_of(int r0, int r1, std::uint64_t indices) {
  Block block{static_cast<std::byte>(r0), static_cast<std::byte>(r1)};
  for (std::size_t i = 0; i < 6; ++i) block[i + 2] = static_cast<std::byte>(indices >> (8 * i));
  return block;
}

// 0 1 2 .. 7, 0 1 2 .. 7.
constexpr std::uint64_t kOneOfEach = 0xFAC688FAC688U;

// The formulas of the specification in real numbers.
double specified(int r0, int r1, int index) {
  if (index == 0) return r0;
  if (index == 1) return r1;
  if (r0 > r1) return ((8 - index) * r0 + (index - 1) * r1) / 7.0;
  if (index == 6) return 0;
  if (index == 7) return 255;
  return ((6 - index) * r0 + (index - 1) * r1) / 5.0;
}

TEST(Bc4Decoder, EveryPairOfEndPointsAndEveryIndex) {
  for (int r0 = 0; r0 < 256; ++r0) {
    for (int r1 = 0; r1 < 256; ++r1) {
      const Block block = block_of(r0, r1, kOneOfEach);
      const std::array<float, 16> values = decode_bc4_block(block);
      const std::array<std::uint8_t, 16> bytes = decode_bc4_block_u8(block);
      for (std::size_t i = 0; i < 16; ++i) {
        const double expected = specified(r0, r1, static_cast<int>(i % 8));
        ASSERT_EQ(values[i], static_cast<float>(expected)) << r0 << " " << r1 << " index " << i % 8;
        ASSERT_EQ(bytes[i], std::lround(expected)) << r0 << " " << r1 << " index " << i % 8;
      }
    }
  }
}

TEST(Bc4Decoder, EveryTexelHasItsOwnThreeBits) {
  for (const auto& [r0, r1] : {std::pair{200, 30}, {30, 200}}) {
    for (unsigned texel = 0; texel < 16; ++texel) {
      for (std::uint64_t index = 0; index < 8; ++index) {
        const std::array<float, 16> values = decode_bc4_block(block_of(r0, r1, index << (3 * texel)));
        for (unsigned i = 0; i < 16; ++i)
          ASSERT_EQ(values[i], static_cast<float>(specified(r0, r1, i == texel ? static_cast<int>(index) : 0)));
      }
    }
  }
}

std::vector<std::byte> random_bytes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

constexpr std::size_t kWidth = 20;
constexpr std::size_t kHeight = 12;
std::size_t block_index(std::size_t x, std::size_t y) { return y / 4 * (kWidth / 4) + x / 4; }

TEST(Bc4Decoder, ImageIsItsBlocksInRows) {
  const std::vector<std::byte> blocks = random_bytes(kWidth * kHeight / 2, 5);
  std::vector<std::byte> bytes(kWidth * kHeight);
  std::vector<float> values(kWidth * kHeight);
  decode_bc4_image(blocks, kWidth, kHeight, bytes);
  decode_bc4_image(blocks, kWidth, kHeight, values);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const auto block = std::span(blocks).subspan(block_index(x, y) * 8).first<8>();
      ASSERT_EQ(values[y * kWidth + x], decode_bc4_block(block)[y % 4 * 4 + x % 4]);
      ASSERT_EQ(std::to_integer<int>(bytes[y * kWidth + x]), decode_bc4_block_u8(block)[y % 4 * 4 + x % 4]);
    }
  }
}

TEST(Bc5Decoder, RedIsTheFirstHalfAndGreenTheSecond) {
  const std::vector<std::byte> blocks = random_bytes(kWidth * kHeight, 6);
  std::vector<std::byte> bytes(kWidth * kHeight * 2);
  std::vector<float> values(kWidth * kHeight * 2);
  decode_bc5_image(blocks, kWidth, kHeight, bytes);
  decode_bc5_image(blocks, kWidth, kHeight, values);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const auto block = std::span(blocks).subspan(block_index(x, y) * 16).first<16>();
      const std::size_t i = y % 4 * 4 + x % 4;
      for (std::size_t c = 0; c < 2; ++c) {
        const float expected = decode_bc4_block(block.subspan(c * 8).first<8>())[i];
        ASSERT_EQ(decode_bc5_block(block)[i][c], expected);
        ASSERT_EQ(values[(y * kWidth + x) * 2 + c], expected);
        ASSERT_EQ(std::to_integer<int>(bytes[(y * kWidth + x) * 2 + c]), std::lround(expected));
      }
    }
  }
}

TEST(Bc3Decoder, ColorIsAlwaysFourColorsAndAlphaIsABc4Block) {
  const std::vector<std::byte> blocks = random_bytes(kWidth * kHeight, 7);
  std::vector<std::byte> rgba(kWidth * kHeight * 4);
  decode_bc3_image(blocks, kWidth, kHeight, rgba);
  int ascending = 0;
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const auto block = std::span(blocks).subspan(block_index(x, y) * 16).first<16>();
      const std::size_t i = y % 4 * 4 + x % 4;
      // The colours of BC1 with the end points in the order that selects four colours; exchanging them
      // exchanges indices 0 1 and 2 3.
      std::array<std::byte, 8> colors{};
      std::copy(block.begin() + 8, block.end(), colors.begin());
      const auto color = [&](std::size_t at) { return std::to_integer<int>(colors[at]) | std::to_integer<int>(colors[at + 1]) << 8; };
      if (color(0) < color(2)) {
        ++ascending;
        std::swap(colors[0], colors[2]);
        std::swap(colors[1], colors[3]);
        for (std::size_t at = 4; at < 8; ++at) colors[at] ^= std::byte{0x55};
      }
      ASSERT_NE(color(0), color(2)) << "choose another seed";
      const Bc1Texels expected = decode_bc1_block(colors);
      for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(std::to_integer<int>(rgba[(y * kWidth + x) * 4 + c]), expected[i][c]);
      ASSERT_EQ(std::to_integer<int>(rgba[(y * kWidth + x) * 4 + 3]), decode_bc4_block_u8(block.first<8>())[i]);
    }
  }
  ASSERT_GT(ascending, 0);
}

TEST(Bc3Decoder, EqualColorsAreOneOpaqueColor) {
  std::array<std::byte, 16> block{};
  block[0] = std::byte{255};                                                       // alpha 255 at index 0
  for (std::size_t i = 12; i < 16; ++i) block[i] = std::byte{0xFF};                // colour index 3 everywhere: would be transparent in BC1
  block[8] = block[10] = std::byte{0xE0}, block[9] = block[11] = std::byte{0x07};  // green
  for (const auto& texel : decode_bc3_block(block)) ASSERT_EQ(texel, (std::array<std::uint8_t, 4>{0, 255, 0, 255}));
}

}  // namespace
}  // namespace vt::store
