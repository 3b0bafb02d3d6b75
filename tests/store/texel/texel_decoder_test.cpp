// Samples of every format against values written down by hand or computed from the format's definition; and
// blocks of one colour.
#include "store/texel/texel_decoder.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "store/io/bytes.h"
#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "store/texel/half.h"
#include "store/texel/solid_block.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using test::Bytes;

// The samples of a 4 x 4 tile that repeats `block` (one texel, or one block).
std::vector<float> decoded(TexelFormat format, const Bytes& block) {
  const FormatInfo& info = format_info(format);
  Bytes payload;
  while (payload.size() < payload_bytes(info, 4, 4)) payload.insert(payload.end(), block.begin(), block.end());
  std::vector<float> out(16UL * info.channels);
  decode_texels(format, payload, 4, 4, out);
  return out;
}
template <class Word>
Bytes words(std::initializer_list<Word> values) {
  Bytes bytes(values.size() * sizeof(Word));
  std::size_t at = 0;
  for (const Word value : values) {
    put<Word>(bytes, at, value);
    at += sizeof(Word);
  }
  return bytes;
}
void expect_texels(TexelFormat format, const Bytes& block, const std::vector<float>& texel) {
  const std::vector<float> all = decoded(format, block);
  ASSERT_EQ(texel.size(), format_info(format).channels);
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], texel[i % texel.size()]) << format_info(format).name << ", sample " << i;
}

TEST(TexelDecoder, CodesAndNumbersAreThemselves) {
  using B = std::uint8_t;
  using W = std::uint16_t;
  using D = std::uint32_t;
  expect_texels(TexelFormat::kR8, words<B>({200}), {200});
  expect_texels(TexelFormat::kRg8, words<B>({0, 255}), {0, 255});
  expect_texels(TexelFormat::kRgb8, words<B>({1, 2, 3}), {1, 2, 3});
  expect_texels(TexelFormat::kRgba8, words<B>({1, 2, 3, 4}), {1, 2, 3, 4});
  expect_texels(TexelFormat::kR16, words<W>({65535}), {65535});
  expect_texels(TexelFormat::kRg16, words<W>({256, 1}), {256, 1});
  expect_texels(TexelFormat::kRgba16, words<W>({1, 20000, 40000, 65534}), {1, 20000, 40000, 65534});
  expect_texels(TexelFormat::kR16Float, words<W>({0xC000}), {-2.0F});
  expect_texels(TexelFormat::kRg16Float, words<W>({0x3C00, 0x0001}), {1.0F, 0x1p-24F});
  expect_texels(TexelFormat::kRgba16Float, words<W>({0x7BFF, 0x7C00, 0x8000, 0x3555}),
                {65504.0F, INFINITY, -0.0F, float_from_half(0x3555)});
  const auto bits = [](float value) { return std::bit_cast<D>(value); };
  expect_texels(TexelFormat::kR32Float, words<D>({bits(1.5F)}), {1.5F});
  expect_texels(TexelFormat::kRg32Float, words<D>({bits(-1e30F), bits(0.1F)}), {-1e30F, 0.1F});
  expect_texels(TexelFormat::kRgba32Float, words<D>({bits(1), bits(2), bits(3), bits(4)}), {1, 2, 3, 4});
  // Mantissas 1, 256, 511 and the exponent 24 - 24: the numbers as they are; then the largest exponent.
  expect_texels(TexelFormat::kRgb9e5, words<D>({1U | 256U << 9 | 511U << 18 | 24U << 27}), {1, 256, 511});
  expect_texels(TexelFormat::kRgb9e5, words<D>({511U | 31U << 27}), {65408, 0, 0});
  EXPECT_TRUE(std::isnan(decoded(TexelFormat::kR16Float, words<W>({kHalfNoData}))[0]));
}

TEST(TexelDecoder, BlocksOfEndPointsAreOnTheScaleOfBytes) {
  using B = std::uint8_t;
  // White and black, all texels index 2: two thirds of white.
  const Bytes bc1 = words<B>({0xFF, 0xFF, 0, 0, 0xAA, 0xAA, 0xAA, 0xAA});
  expect_texels(TexelFormat::kBc1, bc1, {170, 170, 170});
  // End points 255 and 1, all texels index 0.
  const Bytes bc4 = words<B>({255, 1, 0, 0, 0, 0, 0, 0});
  expect_texels(TexelFormat::kBc4, bc4, {255});
  // All texels index 2 (binary 010 over and over): six sevenths of 255 and one of 1, not rounded.
  const Bytes mixed = words<B>({255, 1, 0x92, 0x24, 0x49, 0x92, 0x24, 0x49});
  expect_texels(TexelFormat::kBc4, mixed, {static_cast<float>((6.0 * 255 + 1) / 7)});
  Bytes bc5 = bc4;
  bc5.insert(bc5.end(), mixed.begin(), mixed.end());
  expect_texels(TexelFormat::kBc5, bc5, {255, static_cast<float>((6.0 * 255 + 1) / 7)});
  Bytes bc3 = bc4;
  bc3.insert(bc3.end(), bc1.begin(), bc1.end());
  expect_texels(TexelFormat::kBc3, bc3, {170, 170, 170, 255});
}

TEST(SolidBlock, OfBc7IsItsColourExactly) {
  for (unsigned value = 0; value < 256; ++value) {
    const std::array<std::uint8_t, 4> rgba = {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(255 - value),
                                              static_cast<std::uint8_t>(value * 7), static_cast<std::uint8_t>(value * 13)};
    const auto block = solid_bc7_block(rgba);
    for (const auto& texel : decode_bc7_block(block)) ASSERT_EQ(texel, rgba) << value;
    expect_texels(TexelFormat::kBc7, Bytes(block.begin(), block.end()),
                  {static_cast<float>(rgba[0]), static_cast<float>(rgba[1]), static_cast<float>(rgba[2]), static_cast<float>(rgba[3])});
  }
}

TEST(SolidBlock, OfBc6hIsItsColourExactlyForEveryFiniteHalf) {
  for (std::uint32_t half = 0; half < 0x7C00; ++half) {
    const std::array<std::uint16_t, 3> rgb = {static_cast<std::uint16_t>(half), static_cast<std::uint16_t>(0x7BFF - half),
                                              static_cast<std::uint16_t>(half * 7 % 0x7C00)};
    for (const auto& texel : decode_bc6h_block(solid_bc6h_block(rgb))) ASSERT_EQ(texel, rgb) << half;
  }
  const auto block = solid_bc6h_block({0x3C00, 0, 0x7BFF});
  expect_texels(TexelFormat::kBc6h, Bytes(block.begin(), block.end()), {1, 0, 65504});
}

}  // namespace
}  // namespace vt::store
