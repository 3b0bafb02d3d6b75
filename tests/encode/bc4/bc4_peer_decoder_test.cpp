// BC3, BC4 and BC5 as two decoders of others read them: the OpenGL driver and libsquish.
#include <gtest/gtest.h>
#include <squish.h>

#include <cmath>
#include <random>

#include "store/texel/bc3.h"
#include "store/texel/bc4.h"
#include "tests/encode/opengl_decoder.h"

namespace vt::store {
namespace {

constexpr std::size_t kEdge = 128;

std::vector<std::byte> random_blocks(std::size_t bytes) {
  std::mt19937 random(11);
  std::vector<std::byte> blocks(bytes);
  for (std::byte& byte : blocks) byte = static_cast<std::byte>(random());
  return blocks;
}

// Decoders that work in 8 bits round or cut the fraction: less than one code from the exact value; the last
// part is for float.
constexpr double kOneCode = 1.0 + 1e-3;

TEST(Bc4Decoder, AgreesWithOpenGlInEveryPairOfEndPoints) {
  constexpr std::size_t kAll = 1024;  // 256 x 256 blocks
  std::vector<std::byte> blocks = random_blocks(kAll * kAll / 2);
  for (std::size_t pair = 0; pair < 65536; ++pair) {
    blocks[pair * 8] = static_cast<std::byte>(pair / 256);
    blocks[pair * 8 + 1] = static_cast<std::byte>(pair % 256);
  }
  std::string why;
  const auto theirs = encode::decoded_by_opengl(encode::GlBlockFormat::kRedRgtc1, blocks, kAll, kAll, why);
  if (!theirs) GTEST_SKIP() << why;
  std::vector<float> ours(kAll * kAll);
  decode_bc4_image(blocks, kAll, kAll, ours);
  for (std::size_t i = 0; i < ours.size(); ++i) ASSERT_NEAR(double{(*theirs)[i * 4]} * 255, double{ours[i]}, kOneCode) << "texel " << i;
}

TEST(Bc5Decoder, AgreesWithOpenGl) {
  const std::vector<std::byte> blocks = random_blocks(kEdge * kEdge);
  std::string why;
  const auto theirs = encode::decoded_by_opengl(encode::GlBlockFormat::kRgRgtc2, blocks, kEdge, kEdge, why);
  if (!theirs) GTEST_SKIP() << why;
  std::vector<float> ours(kEdge * kEdge * 2);
  decode_bc5_image(blocks, kEdge, kEdge, ours);
  for (std::size_t i = 0; i < ours.size(); ++i)
    ASSERT_NEAR(double{(*theirs)[i / 2 * 4 + i % 2]} * 255, double{ours[i]}, kOneCode) << "value " << i;
}

TEST(Bc3Decoder, AgreesWithOpenGl) {
  const std::vector<std::byte> blocks = random_blocks(kEdge * kEdge);
  std::string why;
  const auto theirs = encode::decoded_by_opengl(encode::GlBlockFormat::kRgbaDxt5, blocks, kEdge, kEdge, why);
  if (!theirs) GTEST_SKIP() << why;
  std::vector<std::byte> ours(kEdge * kEdge * 4);
  decode_bc3_image(blocks, kEdge, kEdge, ours);
  // Both whole numbers.
  for (std::size_t i = 0; i < ours.size(); ++i)
    ASSERT_LE(std::abs(std::lround(double{(*theirs)[i]} * 255) - std::to_integer<int>(ours[i])), 1) << "value " << i;
}

TEST(Bc3Decoder, AgreesWithLibsquish) {
  const std::vector<std::byte> blocks = random_blocks(kEdge * kEdge);
  for (std::size_t at = 0; at < blocks.size(); at += 16) {
    std::array<squish::u8, 64> theirs{};
    squish::Decompress(theirs.data(), &blocks[at], squish::kDxt5);
    const auto ours = decode_bc3_block(std::span(blocks).subspan(at).first<16>());
    for (std::size_t i = 0; i < 64; ++i) ASSERT_LE(std::abs(theirs[i] - ours[i / 4][i % 4]), 1) << "block " << at / 16;
  }
}

}  // namespace
}  // namespace vt::store
