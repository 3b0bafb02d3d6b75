#include "store/texel_decoder.h"

#include <cassert>
#include <cstdint>
#include <cstring>

#include "store/bc1.h"

namespace vt::store {
namespace {

void decode_bc1(std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  const std::size_t columns = width / 4;
  for (std::size_t b = 0; b < columns * (height / 4); ++b) {
    const Bc1Texels texels = decode_bc1_block(std::span<const std::byte, 8>(payload.subspan(8 * b, 8)));
    for (std::size_t i = 0; i < 16; ++i) {
      const std::size_t x = b % columns * 4 + i % 4;
      const std::size_t y = b / columns * 4 + i / 4;
      for (std::size_t c = 0; c < 3; ++c) out[(y * width + x) * 3 + c] = static_cast<float>(texels[i][c]);
    }
  }
}

}  // namespace

void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  const FormatInfo& info = format_info(format);
  const std::size_t samples = width * height * info.channels;
  assert(payload.size() == payload_bytes(info, width, height) && out.size() >= samples);
  switch (format) {
    case TexelFormat::kRgb8:
    case TexelFormat::kRgba8:
      for (std::size_t i = 0; i < samples; ++i) out[i] = static_cast<float>(std::to_integer<std::uint8_t>(payload[i]));
      return;
    case TexelFormat::kBc1:
      decode_bc1(payload, width, height, out);
      return;
    case TexelFormat::kR32Float:
    case TexelFormat::kRg32Float:
    case TexelFormat::kRgba32Float:
      std::memcpy(out.data(), payload.data(), samples * sizeof(float));
      return;
    case TexelFormat::kHash128:
      break;
  }
  assert(false && "a format without samples");
}

}  // namespace vt::store
