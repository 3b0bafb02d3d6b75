#include "store/texel/block_enlarger.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "store/io/bytes.h"
#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "store/texel/half.h"
#include "store/texel/solid_block.h"

namespace vt::store {
namespace {

// ---- bc1, bc3, bc4 and bc5 are made of one or two pieces of 8 bytes: two end points, then an index a texel in the upper bits ----

constexpr int kColorBits = 2;    // of an index in a piece of colours
constexpr int kChannelBits = 3;  // in a piece of one channel

// One piece: the index of the coarse texel under each of the 16 fine texels.
void enlarge_piece(int index_bits, std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps,
                   std::span<std::byte> fine) {
  const auto coarse_bits = get<std::uint64_t>(coarse, 0);
  const int end_point_bits = 64 - 16 * index_bits;
  const std::uint64_t index_mask = (std::uint64_t{1} << index_bits) - 1;
  std::uint64_t fine_bits = coarse_bits & ((std::uint64_t{1} << end_point_bits) - 1);
  for (int texel = 0; texel < 16; ++texel) {
    const std::int64_t coarse_x = ((x * 4 + texel % 4) >> steps) & 3;
    const std::int64_t coarse_y = ((y * 4 + texel / 4) >> steps) & 3;
    const std::uint64_t index = coarse_bits >> (end_point_bits + index_bits * (coarse_y * 4 + coarse_x)) & index_mask;
    fine_bits |= index << (end_point_bits + index_bits * texel);
  }
  put<std::uint64_t>(fine, 0, fine_bits);
}

template <int... kIndexBits>
void enlarge_pieces(std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps, std::span<std::byte> fine) {
  std::size_t at = 0;
  ((enlarge_piece(kIndexBits, coarse.subspan(at, 8), x, y, steps, fine.subspan(at, 8)), at += 8), ...);
}

// ---- bc6h and bc7 have subsets of texels, whose shapes cannot be enlarged ----

// From 4 times on a fine block lies inside one coarse texel and is that texel. Enlarged twice it covers 2 x 2
// texels, and is their mean.
template <class Texels, class Mean>
auto texel_under(const Texels& coarse, std::int64_t x, std::int64_t y, int steps, const Mean& mean) {
  const auto at = [&](std::int64_t column, std::int64_t row) { return coarse[static_cast<std::size_t>(row * 4 + column)]; };
  const std::int64_t first_x = ((x * 4) >> steps) & 3;
  const std::int64_t first_y = ((y * 4) >> steps) & 3;
  auto texel = at(first_x, first_y);
  if (steps > 1) return texel;
  for (std::size_t c = 0; c < texel.size(); ++c)
    texel[c] = mean(at(first_x, first_y)[c], at(first_x + 1, first_y)[c], at(first_x, first_y + 1)[c], at(first_x + 1, first_y + 1)[c]);
  return texel;
}

void enlarge_bc6h(std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps, std::span<std::byte> fine) {
  const auto mean = [](std::uint16_t a, std::uint16_t b, std::uint16_t c, std::uint16_t d) {
    return half_from_float((float_from_half(a) + float_from_half(b) + float_from_half(c) + float_from_half(d)) / 4.0F);
  };
  std::ranges::copy(solid_bc6h_block(texel_under(decode_bc6h_block(coarse.first<16>()), x, y, steps, mean)), fine.begin());
}

void enlarge_bc7(std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps, std::span<std::byte> fine) {
  const auto mean = [](unsigned a, unsigned b, unsigned c, unsigned d) { return static_cast<std::uint8_t>((a + b + c + d + 2) / 4); };
  std::ranges::copy(solid_bc7_block(texel_under(decode_bc7_block(coarse.first<16>()), x, y, steps, mean)), fine.begin());
}

struct Enlarger {
  TexelFormat format;
  void (*enlarge)(std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps, std::span<std::byte> fine);
};
constexpr std::array kEnlargers = {
    Enlarger{TexelFormat::kBc1, enlarge_pieces<kColorBits>},
    Enlarger{TexelFormat::kBc3, enlarge_pieces<kChannelBits, kColorBits>},
    Enlarger{TexelFormat::kBc4, enlarge_pieces<kChannelBits>},
    Enlarger{TexelFormat::kBc5, enlarge_pieces<kChannelBits, kChannelBits>},
    Enlarger{TexelFormat::kBc6h, enlarge_bc6h},
    Enlarger{TexelFormat::kBc7, enlarge_bc7},
};
static_assert(has_one_row_each(kEnlargers, is_block_format));

}  // namespace

void enlarge_block(TexelFormat format, std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps,
                   std::span<std::byte> fine) {
  assert(coarse.size() == format_info(format).block_bytes && fine.size() == coarse.size() && steps >= 1);
  row_of(kEnlargers, format).enlarge(coarse, x, y, steps, fine);
}

}  // namespace vt::store
