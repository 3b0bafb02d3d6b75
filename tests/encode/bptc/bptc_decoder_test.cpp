#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "tests/encode/bptc/bptc_peers.h"
#include "tests/encode/opengl_decoder.h"
#include "tests/support/temp_folder.h"

namespace vt::store {
namespace {

using encode::BptcFormat;

// 512 x 256 blocks: 131072 of them.
constexpr std::size_t kWidth = 2048;
constexpr std::size_t kHeight = 1024;

// Random bits, with the modes by turns forced into the first ones. A sixteenth has end points and indices of
// all zeros or all ones.
std::vector<std::byte> random_blocks(std::span<const std::pair<unsigned, unsigned>> codes_and_bits) {
  std::mt19937_64 random(11);
  std::vector<std::byte> blocks(kWidth * kHeight);
  for (std::size_t i = 0; i < blocks.size() / 16; ++i) {
    std::array<std::uint64_t, 2> words{random(), random()};
    if (i % 16 == 7) words[random() % 2] = 0;
    if (i % 16 == 15) words[random() % 2] = ~std::uint64_t{0};
    const auto [code, bits] = codes_and_bits[i % codes_and_bits.size()];
    words[0] = (words[0] >> bits << bits) | code;
    for (std::size_t byte = 0; byte < 16; ++byte) blocks[i * 16 + byte] = static_cast<std::byte>(words[byte / 8] >> (byte % 8 * 8));
  }
  return blocks;
}

std::vector<std::byte> random_bc7_blocks() {
  std::vector<std::pair<unsigned, unsigned>> modes;
  for (unsigned mode = 0; mode < 8; ++mode) modes.emplace_back(1U << mode, mode + 1);
  modes.emplace_back(0, 8);  // reserved
  return random_blocks(modes);
}

std::vector<std::byte> random_bc6h_blocks() {
  std::vector<std::pair<unsigned, unsigned>> modes{{0, 2}, {1, 2}};
  for (const unsigned low : {2U, 3U})
    for (unsigned high = 0; high < 8; ++high) modes.emplace_back(low | high << 2U, 5);  // four of them reserved
  return random_blocks(modes);
}

// Independent of store/texel/half.h: the definition of binary16 in real numbers, for what is not negative.
float float_of_half(std::uint16_t half) {
  const int exponent = half >> 10;
  const float mantissa = static_cast<float>(half & 1023);
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024.0F + mantissa, exponent - 25);
}

void expect_bc7_equal(const std::vector<std::byte>& blocks, const std::vector<float>& peer) {
  std::vector<std::byte> ours(kWidth * kHeight * 4);
  decode_bc7_image(blocks, kWidth, kHeight, ours);
  std::map<int, int> wrong;  // of each mode
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const std::size_t x = i / 4 % kWidth, y = i / 4 / kWidth;
    const std::size_t block = y / 4 * (kWidth / 4) + x / 4;
    // n / 255 as a float comes back as n: the float is wrong by a millionth of a step at most.
    if (std::lround(peer[i] * 255.0F) != std::to_integer<int>(ours[i]))
      ++wrong[std::countr_zero(std::to_integer<std::uint8_t>(blocks[block * 16]))];
  }
  for (const auto& [mode, count] : wrong) ADD_FAILURE() << "mode " << mode << ": " << count << " values differ";
}

void expect_bc6h_equal(const std::vector<std::byte>& blocks, const std::vector<float>& peer) {
  std::vector<std::byte> ours(kWidth * kHeight * 8);
  decode_bc6h_image(blocks, kWidth, kHeight, ours);
  std::map<int, int> wrong;  // of each mode
  for (std::size_t i = 0; i < kWidth * kHeight * 4; ++i) {
    const std::size_t x = i / 4 % kWidth, y = i / 4 / kWidth;
    const int code = std::to_integer<int>(blocks[(y / 4 * (kWidth / 4) + x / 4) * 16]) & 31;
    const auto half = static_cast<std::uint16_t>(std::to_integer<unsigned>(ours[i * 2]) | std::to_integer<unsigned>(ours[i * 2 + 1]) << 8U);
    if (peer[i] != float_of_half(half)) ++wrong[(code & 2) == 0 ? code & 3 : code];
  }
  for (const auto& [mode, count] : wrong) ADD_FAILURE() << "mode " << mode << ": " << count << " values differ";
}

TEST(Bc7Decoder, EveryModeAsOpenGl) {
  const std::vector<std::byte> blocks = random_bc7_blocks();
  std::string why;
  const auto peer = encode::decoded_by_opengl(encode::GlBlockFormat::kRgbaBptcUnorm, blocks, kWidth, kHeight, why);
  if (!peer) GTEST_SKIP() << why;
  expect_bc7_equal(blocks, *peer);
}

TEST(Bc7Decoder, EveryModeAsOpenImageIo) {
  const std::vector<std::byte> blocks = random_bc7_blocks();
  const test::TempFolder folder;
  std::string why;
  const auto peer = encode::decoded_by_openimageio(BptcFormat::kBc7, blocks, kWidth, kHeight, folder.path().string(), why);
  ASSERT_TRUE(peer) << why;
  expect_bc7_equal(blocks, *peer);
}

TEST(Bc6hDecoder, EveryModeAsOpenGl) {
  const std::vector<std::byte> blocks = random_bc6h_blocks();
  std::string why;
  const auto peer = encode::decoded_by_opengl(encode::GlBlockFormat::kRgbBptcUnsignedFloat, blocks, kWidth, kHeight, why);
  if (!peer) GTEST_SKIP() << why;
  expect_bc6h_equal(blocks, *peer);
}

TEST(Bc6hDecoder, EveryModeAsOpenImageIo) {
  const std::vector<std::byte> blocks = random_bc6h_blocks();
  const test::TempFolder folder;
  std::string why;
  const auto peer = encode::decoded_by_openimageio(BptcFormat::kBc6hUnsigned, blocks, kWidth, kHeight, folder.path().string(), why);
  ASSERT_TRUE(peer) << why;
  expect_bc6h_equal(blocks, *peer);
}

TEST(Bc6hDecoder, EveryValueIsAFiniteHalfNotNegative) {
  const std::vector<std::byte> blocks = random_bc6h_blocks();
  for (std::size_t i = 0; i < blocks.size(); i += 16)
    for (const auto& texel : decode_bc6h_block(std::span(blocks).subspan(i).first<16>()))
      for (const std::uint16_t half : texel) ASSERT_LE(half, 0x7BFF);
}

TEST(BptcDecoders, ReservedModesAreBlack) {
  std::array<std::byte, 16> block;
  block.fill(std::byte{0xFF});
  block[0] = std::byte{0};
  EXPECT_EQ(decode_bc7_block(block), Bc7Texels{});
  for (const int code : {19, 23, 27, 31}) {
    block[0] = static_cast<std::byte>(0xE0 | code);
    EXPECT_EQ(decode_bc6h_block(block), Bc6hTexels{}) << code;
  }
}

}  // namespace
}  // namespace vt::store
