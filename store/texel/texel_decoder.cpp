#include "store/texel/texel_decoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <vector>

#include "store/io/bytes.h"
#include "store/texel/bc1.h"
#include "store/texel/bc3.h"
#include "store/texel/bc4.h"
#include "store/texel/bc6h.h"
#include "store/texel/bc7.h"
#include "store/texel/half.h"
#include "store/texel/rgb9e5.h"

namespace vt::store {
namespace {

using Payload = std::span<const std::byte>;

// One number after another.
void decode_unorm8(Payload payload, std::size_t, std::size_t, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(payload[i]);
}
void decode_unorm16(Payload payload, std::size_t, std::size_t, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(get<std::uint16_t>(payload, i * 2));
}
void decode_half(Payload payload, std::size_t, std::size_t, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = float_from_half(get<std::uint16_t>(payload, i * 2));
}
void decode_float(Payload payload, std::size_t, std::size_t, std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::bit_cast<float>(get<std::uint32_t>(payload, i * 4));
}

// Blocks of colours, through RGBA8, of which the first channels are kept.
template <void (*kDecodeImage)(Payload, std::size_t, std::size_t, std::span<std::byte>), std::size_t kChannels>
void decode_color_blocks(Payload payload, std::size_t width, std::size_t height, std::span<float> out) {
  thread_local std::vector<std::byte> rgba;
  rgba.resize(width * height * 4);
  kDecodeImage(payload, width, height, rgba);
  for (std::size_t texel = 0; texel < width * height; ++texel)
    for (std::size_t c = 0; c < kChannels; ++c) out[texel * kChannels + c] = static_cast<float>(rgba[texel * 4 + c]);
}

void decode_bc6h(Payload payload, std::size_t width, std::size_t height, std::span<float> out) {
  thread_local std::vector<std::byte> rgba16f;
  rgba16f.resize(width * height * 8);
  decode_bc6h_image(payload, width, height, rgba16f);
  for (std::size_t texel = 0; texel < width * height; ++texel)
    for (std::size_t c = 0; c < 3; ++c) out[texel * 3 + c] = float_from_half(get<std::uint16_t>(rgba16f, texel * 8 + c * 2));
}

void decode_rgb9e5(Payload payload, std::size_t, std::size_t, std::span<float> out) {
  for (std::size_t texel = 0; texel < payload.size() / 4; ++texel) {
    const auto rgb = unpack_rgb9e5(get<std::uint32_t>(payload, texel * 4));
    std::copy(rgb.begin(), rgb.end(), out.begin() + static_cast<std::ptrdiff_t>(texel * 3));
  }
}

struct Decoder {
  TexelFormat format;
  void (*to_numbers)(Payload payload, std::size_t width, std::size_t height, std::span<float> out);
  void (*to_plain)(Payload blocks, std::size_t width, std::size_t height, std::span<std::byte> out) = nullptr;  // of block formats
};
constexpr std::array kDecoders = {
    Decoder{TexelFormat::kRgb8, decode_unorm8},
    Decoder{TexelFormat::kRgba8, decode_unorm8},
    Decoder{TexelFormat::kBc1, decode_color_blocks<decode_bc1_image, 3>, decode_bc1_image},
    Decoder{TexelFormat::kR32Float, decode_float},
    Decoder{TexelFormat::kRg32Float, decode_float},
    Decoder{TexelFormat::kRgba32Float, decode_float},
    Decoder{TexelFormat::kR8, decode_unorm8},
    Decoder{TexelFormat::kRg8, decode_unorm8},
    Decoder{TexelFormat::kR16, decode_unorm16},
    Decoder{TexelFormat::kRg16, decode_unorm16},
    Decoder{TexelFormat::kRgba16, decode_unorm16},
    Decoder{TexelFormat::kR16Float, decode_half},
    Decoder{TexelFormat::kRg16Float, decode_half},
    Decoder{TexelFormat::kRgba16Float, decode_half},
    Decoder{TexelFormat::kRgb9e5, decode_rgb9e5},
    Decoder{TexelFormat::kBc3, decode_color_blocks<decode_bc3_image, 4>, decode_bc3_image},
    Decoder{TexelFormat::kBc4, decode_bc4_image, decode_bc4_image},
    Decoder{TexelFormat::kBc5, decode_bc5_image, decode_bc5_image},
    Decoder{TexelFormat::kBc6h, decode_bc6h, decode_bc6h_image},
    Decoder{TexelFormat::kBc7, decode_color_blocks<decode_bc7_image, 4>, decode_bc7_image},
};
static_assert(has_one_row_each(kDecoders, has_samples));
static_assert(std::ranges::all_of(kDecoders, [](const Decoder& row) {
  return (row.to_plain != nullptr) == is_block_format(format_info(row.format));
}));

}  // namespace

void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  assert(payload.size() == payload_bytes(format_info(format), width, height));
  assert(out.size() == width * height * format_info(format).channels);
  row_of(kDecoders, format).to_numbers(payload, width, height, out);
}

void decode_blocks(TexelFormat format, std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> out) {
  assert(blocks.size() == payload_bytes(format_info(format), width, height));
  assert(out.size() == payload_bytes(format_info(format_info(format).decoded_to), width, height));
  row_of(kDecoders, format).to_plain(blocks, width, height, out);
}

}  // namespace vt::store
