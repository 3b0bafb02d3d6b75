#include "store/texel/texel_decoder.h"

#include <algorithm>
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

// One number after another; `number_at` gives the one at a byte offset.
template <class NumberAt>
void decode_numbers(std::size_t sample_bytes, std::span<float> out, const NumberAt& number_at) {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = number_at(i * sample_bytes);
}

// Through RGBA8, of which the first channels are kept.
void decode_colors(void (*decode)(std::span<const std::byte>, std::size_t, std::size_t, std::span<std::byte>),
                   std::span<const std::byte> payload, std::size_t width, std::size_t height, std::size_t channels, std::span<float> out) {
  thread_local std::vector<std::byte> rgba;
  rgba.resize(width * height * 4);
  decode(payload, width, height, rgba);
  for (std::size_t texel = 0; texel < width * height; ++texel)
    for (std::size_t c = 0; c < channels; ++c) out[texel * channels + c] = static_cast<float>(rgba[texel * 4 + c]);
}

void decode_bc6h(std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  thread_local std::vector<std::byte> rgba16f;
  rgba16f.resize(width * height * 8);
  decode_bc6h_image(payload, width, height, rgba16f);
  for (std::size_t texel = 0; texel < width * height; ++texel)
    for (std::size_t c = 0; c < 3; ++c) out[texel * 3 + c] = float_from_half(get<std::uint16_t>(rgba16f, texel * 8 + c * 2));
}

void decode_rgb9e5(std::span<const std::byte> payload, std::span<float> out) {
  for (std::size_t texel = 0; texel < payload.size() / 4; ++texel) {
    const auto rgb = unpack_rgb9e5(get<std::uint32_t>(payload, texel * 4));
    std::copy(rgb.begin(), rgb.end(), out.begin() + static_cast<std::ptrdiff_t>(texel * 3));
  }
}

}  // namespace

void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  const FormatInfo& info = format_info(format);
  assert(payload.size() == payload_bytes(info, width, height) && out.size() == width * height * info.channels);
  switch (info.samples) {
    case SampleKind::kUnorm8:
      return decode_numbers(1, out, [&](std::size_t at) { return static_cast<float>(payload[at]); });
    case SampleKind::kUnorm16:
      return decode_numbers(2, out, [&](std::size_t at) { return static_cast<float>(get<std::uint16_t>(payload, at)); });
    case SampleKind::kHalf:
      return decode_numbers(2, out, [&](std::size_t at) { return float_from_half(get<std::uint16_t>(payload, at)); });
    case SampleKind::kFloat:
      return decode_numbers(4, out, [&](std::size_t at) { return std::bit_cast<float>(get<std::uint32_t>(payload, at)); });
    case SampleKind::kSharedExponent:
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      break;
  }
  switch (format) {
    case TexelFormat::kBc1:
      return decode_colors(decode_bc1_image, payload, width, height, info.channels, out);
    case TexelFormat::kBc3:
      return decode_colors(decode_bc3_image, payload, width, height, info.channels, out);
    case TexelFormat::kBc4:
      return decode_bc4_image(payload, width, height, out);
    case TexelFormat::kBc5:
      return decode_bc5_image(payload, width, height, out);
    case TexelFormat::kBc6h:
      return decode_bc6h(payload, width, height, out);
    case TexelFormat::kBc7:
      return decode_colors(decode_bc7_image, payload, width, height, info.channels, out);
    case TexelFormat::kRgb9e5:
      return decode_rgb9e5(payload, out);
    default:
      assert(false);
  }
}

}  // namespace vt::store
