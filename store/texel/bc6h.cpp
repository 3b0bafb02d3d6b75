#include "store/texel/bc6h.h"

#include <cassert>
#include <optional>

#include "store/texel/bc6h_table.h"
#include "store/texel/bptc_bits.h"
#include "store/texel/bptc_table.h"

namespace vt::store {
namespace {

std::optional<std::size_t> take_mode(BptcBitReader& bits) {
  std::uint32_t code = bits.take(2);
  if (code >= 2) code |= bits.take(3) << 2U;
  for (std::size_t mode = 0; mode < kBc6hModes.size(); ++mode)
    if (kBc6hModes[mode].code == code) return mode;
  return std::nullopt;
}

// Codes of [end][channel]: 16-bit numbers, the differences of transformed modes added.
using Codes = std::array<std::array<std::uint32_t, 3>, 4>;
Codes take_ends(BptcBitReader& bits, std::size_t mode_number) {
  Codes codes{};
  const Bc6hLayout& layout = kBc6hLayouts[mode_number];
  for (std::size_t i = 0; i < layout.count; ++i) {
    const Bc6hPlace& place = layout.places[i];
    codes[place.end][place.channel] |= bits.take(1) << place.bit;
  }
  const Bc6hMode& mode = kBc6hModes[mode_number];
  if (!mode.transformed) return codes;
  const std::uint32_t mask = (1U << mode.base_bits) - 1U;
  for (std::size_t end = 1; end < 4; ++end) {
    for (std::size_t c = 0; c < 3; ++c) {
      // Sign extension by the borrow; the sum wraps within the bits of the base.
      const std::uint32_t sign = 1U << (mode.delta_bits[c] - 1U);
      codes[end][c] = (codes[0][c] + (codes[end][c] ^ sign) - sign) & mask;
    }
  }
  return codes;
}

std::uint32_t unquantized(std::uint32_t code, unsigned bits) {
  if (bits >= 15 || code == 0) return code;
  if (code == (1U << bits) - 1U) return 0xFFFF;
  return ((code << 16U) + 0x8000U) >> bits;
}

}  // namespace

Bc6hTexels decode_bc6h_block(std::span<const std::byte, 16> block) {
  BptcBitReader bits(block);
  const std::optional<std::size_t> mode_number = take_mode(bits);
  if (!mode_number) return {};
  const Bc6hMode& mode = kBc6hModes[*mode_number];
  Codes ends = take_ends(bits, *mode_number);
  for (auto& end : ends)
    for (std::uint32_t& code : end) code = unquantized(code, mode.base_bits);
  const std::size_t partition = mode.subsets == 2 ? bits.take(5) : 0;
  const unsigned index_bits = mode.subsets == 2 ? 3 : 4;

  Bc6hTexels texels;
  for (std::size_t i = 0; i < 16; ++i) {
    const std::uint32_t index = bits.take(index_bits - (bptc_is_anchor(mode.subsets, partition, i) ? 1U : 0U));
    const std::uint32_t weight = bptc_weight(index_bits, index);
    const std::size_t subset = bptc_subset(mode.subsets, partition, i);
    // 31 / 64 takes the largest 16-bit number to the largest finite half.
    for (std::size_t c = 0; c < 3; ++c)
      texels[i][c] = static_cast<std::uint16_t>(bptc_interpolated(ends[2 * subset][c], ends[2 * subset + 1][c], weight) * 31 >> 6U);
  }
  return texels;
}

void decode_bc6h_image(std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> rgba16f) {
  assert(width % 4 == 0 && height % 4 == 0);
  assert(blocks.size() == width * height && rgba16f.size() == width * height * 8);
  constexpr std::uint16_t kOne = 0x3C00;
  for (std::size_t block_y = 0; block_y < height / 4; ++block_y) {
    for (std::size_t block_x = 0; block_x < width / 4; ++block_x) {
      const Bc6hTexels texels = decode_bc6h_block(blocks.subspan((block_y * (width / 4) + block_x) * 16).first<16>());
      for (std::size_t i = 0; i < 16; ++i) {
        const std::size_t texel = (block_y * 4 + i / 4) * width + block_x * 4 + i % 4;
        for (std::size_t c = 0; c < 4; ++c) {
          const std::uint16_t half = c < 3 ? texels[i][c] : kOne;
          rgba16f[texel * 8 + c * 2] = static_cast<std::byte>(half);
          rgba16f[texel * 8 + c * 2 + 1] = static_cast<std::byte>(half >> 8U);
        }
      }
    }
  }
}

}  // namespace vt::store
