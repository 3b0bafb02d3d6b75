#include "store/texel/bc7.h"

#include <bit>
#include <cassert>
#include <cstring>
#include <utility>

#include "store/texel/bptc_bits.h"
#include "store/texel/bptc_table.h"

namespace vt::store {
namespace {

using Color = std::array<std::uint32_t, 4>;
using Indices = std::array<std::uint32_t, 16>;

// `bits` significant bits to 8 by repeating the leading ones.
std::uint32_t expanded(std::uint32_t code, unsigned bits) { return code << (8 - bits) | code >> (2 * bits - 8); }

// End points of all subsets, two each, expanded to 8 bits.
std::array<Color, 6> take_ends(BptcBitReader& bits, const Bc7Mode& mode) {
  const std::size_t count = std::size_t{2} * mode.subsets;
  std::array<Color, 6> ends{};
  for (std::size_t channel = 0; channel < 4; ++channel)
    for (std::size_t end = 0; end < count; ++end) ends[end][channel] = bits.take(channel < 3 ? mode.color_bits : mode.alpha_bits);

  unsigned color_bits = mode.color_bits;
  unsigned alpha_bits = mode.alpha_bits;
  if (mode.p_bits != 0) {
    const std::size_t ends_of_a_bit = mode.p_bits == 1 ? 2 : 1;
    for (std::size_t end = 0; end < count; end += ends_of_a_bit) {
      const std::uint32_t p = bits.take(1);
      for (std::size_t sharer = end; sharer < end + ends_of_a_bit; ++sharer)
        for (std::uint32_t& code : ends[sharer]) code = code << 1U | p;
    }
    ++color_bits;
    if (alpha_bits != 0) ++alpha_bits;
  }
  for (Color& end : ends) {
    for (std::size_t channel = 0; channel < 3; ++channel) end[channel] = expanded(end[channel], color_bits);
    end[3] = alpha_bits != 0 ? expanded(end[3], alpha_bits) : 255;
  }
  return ends;
}

Indices take_indices(BptcBitReader& bits, unsigned index_bits, std::size_t subsets, std::size_t partition) {
  Indices indices{};
  for (std::size_t i = 0; i < 16; ++i) indices[i] = bits.take(index_bits - (bptc_is_anchor(subsets, partition, i) ? 1U : 0U));
  return indices;
}

}  // namespace

Bc7Texels decode_bc7_block(std::span<const std::byte, 16> block) {
  const int mode_number = std::countr_zero(std::to_integer<std::uint8_t>(block[0]));
  if (mode_number == 8) return {};
  const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(mode_number)];

  BptcBitReader bits(block);
  bits.take(static_cast<unsigned>(mode_number) + 1);
  const std::size_t partition = bits.take(mode.partition_bits);
  const std::uint32_t rotation = bits.take(mode.rotation_bits);
  const std::uint32_t index_selection = bits.take(mode.index_selection_bits);
  const std::array<Color, 6> ends = take_ends(bits, mode);
  Indices color_indices = take_indices(bits, mode.index_bits, mode.subsets, partition);
  unsigned color_index_bits = mode.index_bits;
  Indices alpha_indices = color_indices;
  unsigned alpha_index_bits = color_index_bits;
  if (mode.index_bits_more != 0) {
    alpha_indices = take_indices(bits, mode.index_bits_more, 1, 0);
    alpha_index_bits = mode.index_bits_more;
    if (index_selection != 0) {
      std::swap(color_indices, alpha_indices);
      std::swap(color_index_bits, alpha_index_bits);
    }
  }

  Bc7Texels texels;
  for (std::size_t i = 0; i < 16; ++i) {
    const std::size_t subset = bptc_subset(mode.subsets, partition, i);
    const Color& end0 = ends[2 * subset];
    const Color& end1 = ends[2 * subset + 1];
    const std::uint32_t color_weight = bptc_weight(color_index_bits, color_indices[i]);
    for (std::size_t c = 0; c < 3; ++c) texels[i][c] = static_cast<std::uint8_t>(bptc_interpolated(end0[c], end1[c], color_weight));
    texels[i][3] = static_cast<std::uint8_t>(bptc_interpolated(end0[3], end1[3], bptc_weight(alpha_index_bits, alpha_indices[i])));
    // Rotation 1, 2, 3: alpha holds red, green, blue and the other way round.
    if (rotation != 0) std::swap(texels[i][rotation - 1], texels[i][3]);
  }
  return texels;
}

void decode_bc7_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(blocks.size() == width * height && rgba.size() == width * height * 4);
  for (std::size_t block_y = 0; block_y < height / 4; ++block_y) {
    for (std::size_t block_x = 0; block_x < width / 4; ++block_x) {
      const Bc7Texels texels = decode_bc7_block(blocks.subspan((block_y * (width / 4) + block_x) * 16).first<16>());
      for (std::size_t y = 0; y < 4; ++y) std::memcpy(&rgba[((block_y * 4 + y) * width + block_x * 4) * 4], texels[y * 4].data(), 16);
    }
  }
}

}  // namespace vt::store
