#include "store/texel/bc3.h"

#include <cassert>

#include "store/texel/bc1.h"
#include "store/texel/bc4.h"

namespace vt::store {

std::array<std::array<std::uint8_t, 4>, 16> decode_bc3_block(std::span<const std::byte, 16> block) {
  const std::array<std::uint8_t, 16> alpha = decode_bc4_block_u8(block.first<8>());
  Bc1Texels texels = decode_four_color_block(block.last<8>());
  for (std::size_t i = 0; i < 16; ++i) texels[i][3] = alpha[i];
  return texels;
}

void decode_bc3_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(blocks.size() == width * height && rgba.size() == width * height * 4);
  for (std::size_t y = 0; y < height; y += 4) {
    for (std::size_t x = 0; x < width; x += 4) {
      const auto texels = decode_bc3_block(blocks.first<16>());
      blocks = blocks.subspan(16);
      for (std::size_t i = 0; i < 16; ++i)
        for (std::size_t c = 0; c < 4; ++c) rgba[((y + i / 4) * width + x + i % 4) * 4 + c] = std::byte{texels[i][c]};
    }
  }
}

}  // namespace vt::store
