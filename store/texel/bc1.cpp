#include "store/texel/bc1.h"

#include <cassert>

namespace vt::store {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

std::uint32_t little_endian(std::span<const std::byte> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | std::to_integer<std::uint32_t>(bytes[i]);
  return value;
}

// 5:6:5 to 8 bits each by repeating the leading bits, so that 0 stays 0 and the largest code becomes 255.
Rgb rgb_from_565(std::uint32_t color) {
  const std::uint32_t r = color >> 11U & 31U;
  const std::uint32_t g = color >> 5U & 63U;
  const std::uint32_t b = color & 31U;
  return {static_cast<std::uint8_t>(r << 3U | r >> 2U), static_cast<std::uint8_t>(g << 2U | g >> 4U),
          static_cast<std::uint8_t>(b << 3U | b >> 2U)};
}

Bc1Texels decode_colors(std::span<const std::byte, 8> block, bool has_three_color_mode) {
  const std::uint32_t color0 = little_endian(block.subspan<0, 2>());
  const std::uint32_t color1 = little_endian(block.subspan<2, 2>());
  const std::uint32_t indices = little_endian(block.subspan<4, 4>());
  const Rgb end0 = rgb_from_565(color0);
  const Rgb end1 = rgb_from_565(color1);

  // Four opaque colours, or three and transparent black.
  const bool four_colors = !has_three_color_mode || color0 > color1;
  std::array<std::array<std::uint8_t, 4>, 4> palette{};
  for (std::size_t c = 0; c < 3; ++c) {
    const unsigned a = end0[c];
    const unsigned b = end1[c];
    palette[0][c] = end0[c];
    palette[1][c] = end1[c];
    palette[2][c] = static_cast<std::uint8_t>(four_colors ? (2 * a + b + 1) / 3 : (a + b) / 2);
    palette[3][c] = static_cast<std::uint8_t>(four_colors ? (a + 2 * b + 1) / 3 : 0);
  }
  palette[0][3] = palette[1][3] = palette[2][3] = 255;
  palette[3][3] = four_colors ? 255 : 0;

  Bc1Texels texels;
  for (std::size_t i = 0; i < 16; ++i) texels[i] = palette[indices >> (2 * i) & 3U];
  return texels;
}

}  // namespace

Bc1Texels decode_bc1_block(std::span<const std::byte, 8> block) { return decode_colors(block, true); }

Bc1Texels decode_four_color_block(std::span<const std::byte, 8> block) { return decode_colors(block, false); }

void decode_bc1_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(blocks.size() == width / 4 * (height / 4) * 8 && rgba.size() == width * height * 4);
  for (std::size_t block_y = 0; block_y < height / 4; ++block_y) {
    for (std::size_t block_x = 0; block_x < width / 4; ++block_x) {
      const std::span<const std::byte> block = blocks.subspan((block_y * (width / 4) + block_x) * 8, 8);
      const Bc1Texels texels = decode_bc1_block(block.first<8>());
      for (std::size_t i = 0; i < 16; ++i) {
        const std::size_t texel = (block_y * 4 + i / 4) * width + block_x * 4 + i % 4;
        for (std::size_t c = 0; c < 4; ++c) rgba[texel * 4 + c] = std::byte{texels[i][c]};
      }
    }
  }
}

}  // namespace vt::store
