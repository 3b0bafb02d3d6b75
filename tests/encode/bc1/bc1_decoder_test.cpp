#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "store/texel/bc1.h"

namespace vt::store {
namespace {

std::array<std::byte, 8> block_of(unsigned color0, unsigned color1, std::uint32_t indices) {
  return {std::byte(color0),  std::byte(color0 >> 8),  std::byte(color1),        std::byte(color1 >> 8),
          std::byte(indices), std::byte(indices >> 8), std::byte(indices >> 16), std::byte(indices >> 24)};
}

// Independent definition: multiplication instead of shifts, thirds in real numbers and rounded by the
// library.
int expanded(int code, int bits) { return bits == 5 ? code * 8 + code / 4 : code * 4 + code / 16; }
int third(int near, int far) { return static_cast<int>(std::lround((2.0 * near + far) / 3.0)); }

constexpr std::uint32_t kOneOfEach = 0xE4E4E4E4U;  // 0 1 2 3 in every row

TEST(Bc1Decoder, EveryPairOfEveryChannelInBothModes) {
  struct Channel {
    int bits, shift, index;
  };
  for (const Channel channel : {Channel{5, 11, 0}, Channel{6, 5, 1}, Channel{5, 0, 2}}) {
    for (int code0 = 0; code0 < 1 << channel.bits; ++code0) {
      for (int code1 = 0; code1 < 1 << channel.bits; ++code1) {
        const auto color0 = static_cast<unsigned>(code0) << channel.shift;
        const auto color1 = static_cast<unsigned>(code1) << channel.shift;
        const Bc1Texels texels = decode_bc1_block(block_of(color0, color1, kOneOfEach));
        const int a = expanded(code0, channel.bits);
        const int b = expanded(code1, channel.bits);
        const bool four = color0 > color1;
        const int expected[4] = {a, b, four ? third(a, b) : (a + b) / 2, four ? third(b, a) : 0};
        for (std::size_t i = 0; i < 16; ++i) {
          ASSERT_EQ(texels[i][channel.index], expected[i % 4]) << code0 << " " << code1 << " index " << i % 4;
          ASSERT_EQ(texels[i][3], !four && i % 4 == 3 ? 0 : 255);
          for (int other = 0; other < 3; ++other) {
            if (other != channel.index) {
              ASSERT_EQ(texels[i][other], 0);
            }
          }
        }
      }
    }
  }
}

TEST(Bc1Decoder, AllIndexPatternsGoToTheirTexels) {
  // Four colours that differ in all channels; each texel takes each index while the others hold another.
  const unsigned color0 = 0xF81F;
  const unsigned color1 = 0x07E0;
  const Bc1Texels palette = decode_bc1_block(block_of(color0, color1, kOneOfEach));
  for (unsigned texel = 0; texel < 16; ++texel) {
    for (unsigned index = 0; index < 4; ++index) {
      const unsigned rest = (index + 1) % 4;
      std::uint32_t indices = rest * 0x55555555U;
      indices = (indices & ~(3U << 2 * texel)) | index << 2 * texel;
      const Bc1Texels texels = decode_bc1_block(block_of(color0, color1, indices));
      for (unsigned i = 0; i < 16; ++i) ASSERT_EQ(texels[i], palette[i == texel ? index : rest]);
    }
  }
}

TEST(Bc1Decoder, ImageIsItsBlocksInRows) {
  constexpr std::size_t kWidth = 20;
  constexpr std::size_t kHeight = 12;
  std::mt19937 random(5);
  std::vector<std::byte> blocks(kWidth / 4 * kHeight / 4 * 8);
  for (std::byte& byte : blocks) byte = static_cast<std::byte>(random());
  std::vector<std::byte> rgba(kWidth * kHeight * 4);
  decode_bc1_image(blocks, kWidth, kHeight, rgba);
  for (std::size_t y = 0; y < kHeight; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const std::size_t block = y / 4 * (kWidth / 4) + x / 4;
      const Bc1Texels texels = decode_bc1_block(std::span(blocks).subspan(block * 8).first<8>());
      for (std::size_t c = 0; c < 4; ++c) ASSERT_EQ(std::to_integer<int>(rgba[(y * kWidth + x) * 4 + c]), texels[y % 4 * 4 + x % 4][c]);
    }
  }
}

}  // namespace
}  // namespace vt::store
