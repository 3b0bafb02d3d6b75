#include "store/texel/bc4.h"

#include <cassert>

namespace vt::store {
namespace {

// A palette entry is sum / divisor.
struct Fraction {
  std::uint32_t sum = 0;
  std::uint32_t divisor = 1;
};
using Palette = std::array<Fraction, 8>;

// The order of the end points chooses the mode: eight values from r0 to r1, or six with 0 and 255 beside
// them.
Palette palette_of(std::uint32_t r0, std::uint32_t r1) {
  Palette palette{Fraction{r0}, Fraction{r1}};
  if (r0 > r1) {
    for (std::uint32_t i = 1; i < 7; ++i) palette[i + 1] = {(7 - i) * r0 + i * r1, 7};
  } else {
    for (std::uint32_t i = 1; i < 5; ++i) palette[i + 1] = {(5 - i) * r0 + i * r1, 5};
    palette[6] = {0};
    palette[7] = {255};
  }
  return palette;
}

template <class Value, class FromFraction>
std::array<Value, 16> decode(std::span<const std::byte, 8> block, const FromFraction& from_fraction) {
  const Palette fractions = palette_of(std::to_integer<std::uint32_t>(block[0]), std::to_integer<std::uint32_t>(block[1]));
  std::array<Value, 8> palette;
  for (std::size_t i = 0; i < 8; ++i) palette[i] = from_fraction(fractions[i]);

  std::uint64_t indices = 0;
  for (std::size_t i = 8; i-- > 2;) indices = indices << 8U | std::to_integer<std::uint64_t>(block[i]);
  std::array<Value, 16> texels;
  for (std::size_t i = 0; i < 16; ++i) texels[i] = palette[indices >> (3 * i) & 7U];
  return texels;
}

// `decode_block` takes the 8 bytes of one channel of one block; channel c of the image is block c of each
// group of `channels`.
template <std::size_t channels, class Value, class DecodeBlock>
void decode_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<Value> texels,
                  const DecodeBlock& decode_block) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(blocks.size() == width / 4 * (height / 4) * 8 * channels && texels.size() == width * height * channels);
  for (std::size_t y = 0; y < height; y += 4) {
    for (std::size_t x = 0; x < width; x += 4) {
      for (std::size_t c = 0; c < channels; ++c) {
        const auto values = decode_block(blocks.first<8>());
        blocks = blocks.subspan(8);
        for (std::size_t i = 0; i < 16; ++i) texels[((y + i / 4) * width + x + i % 4) * channels + c] = static_cast<Value>(values[i]);
      }
    }
  }
}

}  // namespace

std::array<float, 16> decode_bc4_block(std::span<const std::byte, 8> block) {
  return decode<float>(block, [](Fraction f) { return static_cast<float>(f.sum) / static_cast<float>(f.divisor); });
}

std::array<std::uint8_t, 16> decode_bc4_block_u8(std::span<const std::byte, 8> block) {
  return decode<std::uint8_t>(block, [](Fraction f) { return static_cast<std::uint8_t>((f.sum + f.divisor / 2) / f.divisor); });
}

std::array<std::array<float, 2>, 16> decode_bc5_block(std::span<const std::byte, 16> block) {
  const std::array<float, 16> red = decode_bc4_block(block.first<8>());
  const std::array<float, 16> green = decode_bc4_block(block.last<8>());
  std::array<std::array<float, 2>, 16> texels;
  for (std::size_t i = 0; i < 16; ++i) texels[i] = {red[i], green[i]};
  return texels;
}

void decode_bc4_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> r8) {
  decode_image<1>(blocks, width, height, r8, decode_bc4_block_u8);
}
void decode_bc4_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<float> r) {
  decode_image<1>(blocks, width, height, r, decode_bc4_block);
}
void decode_bc5_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rg8) {
  decode_image<2>(blocks, width, height, rg8, decode_bc4_block_u8);
}
void decode_bc5_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<float> rg) {
  decode_image<2>(blocks, width, height, rg, decode_bc4_block);
}

}  // namespace vt::store
