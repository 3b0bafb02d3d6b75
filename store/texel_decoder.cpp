#include "store/texel_decoder.h"

#include <cassert>
#include <cstdint>
#include <cstring>

#include "store/bc1.h"
#include "store/bc3.h"
#include "store/bc4.h"
#include "store/bc6h.h"
#include "store/bc7.h"
#include "store/bytes.h"
#include "store/half.h"
#include "store/rgb9e5.h"

namespace vt::store {
namespace {

// `texel(block, i, c)` is channel c of the block's texel i. Blocks lie in rows of width / 4.
template <std::size_t block_bytes, std::size_t channels, class DecodeBlock, class Sample>
void decode_blocks(std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out,
                   const DecodeBlock& decode_block, const Sample& sample) {
  const std::size_t columns = width / 4;
  for (std::size_t b = 0; b < columns * (height / 4); ++b) {
    const auto block = decode_block(std::span<const std::byte, block_bytes>(payload.subspan(block_bytes * b, block_bytes)));
    for (std::size_t i = 0; i < 16; ++i) {
      const std::size_t x = b % columns * 4 + i % 4;
      const std::size_t y = b / columns * 4 + i / 4;
      for (std::size_t c = 0; c < channels; ++c) out[(y * width + x) * channels + c] = sample(block, i, c);
    }
  }
}

float code_at(const std::array<std::array<std::uint8_t, 4>, 16>& texels, std::size_t i, std::size_t c) {
  return static_cast<float>(texels[i][c]);
}

}  // namespace

void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out) {
  const FormatInfo& info = format_info(format);
  const std::size_t samples = width * height * info.channels;
  assert(payload.size() == payload_bytes(info, width, height) && out.size() >= samples);
  switch (info.samples) {
    case SampleKind::kUnorm8:
      for (std::size_t i = 0; i < samples; ++i) out[i] = static_cast<float>(std::to_integer<std::uint8_t>(payload[i]));
      return;
    case SampleKind::kUnorm16:
      for (std::size_t i = 0; i < samples; ++i) out[i] = static_cast<float>(get<std::uint16_t>(payload, 2 * i));
      return;
    case SampleKind::kHalf:
      for (std::size_t i = 0; i < samples; ++i) out[i] = float_from_half(get<std::uint16_t>(payload, 2 * i));
      return;
    case SampleKind::kFloat:
      std::memcpy(out.data(), payload.data(), samples * sizeof(float));
      return;
    case SampleKind::kSharedExponent:
      for (std::size_t i = 0; i < width * height; ++i) {
        const std::array<float, 3> rgb = unpack_rgb9e5(get<std::uint32_t>(payload, 4 * i));
        for (std::size_t c = 0; c < 3; ++c) out[3 * i + c] = rgb[c];
      }
      return;
    case SampleKind::kBlock:
    case SampleKind::kOpaque:
      break;
  }
  switch (format) {
    case TexelFormat::kBc1:
      decode_blocks<8, 3>(payload, width, height, out, [](auto block) { return decode_bc1_block(block); }, code_at);
      return;
    case TexelFormat::kBc3:
      decode_blocks<16, 4>(payload, width, height, out, [](auto block) { return decode_bc3_block(block); }, code_at);
      return;
    case TexelFormat::kBc4:
      decode_bc4_image(payload, width, height, out.first(samples));
      return;
    case TexelFormat::kBc5:
      decode_bc5_image(payload, width, height, out.first(samples));
      return;
    case TexelFormat::kBc6h:
      decode_blocks<16, 3>(payload, width, height, out, [](auto block) { return decode_bc6h_block(block); },
                           [](const Bc6hTexels& texels, std::size_t i, std::size_t c) { return float_from_half(texels[i][c]); });
      return;
    case TexelFormat::kBc7:
      decode_blocks<16, 4>(payload, width, height, out, [](auto block) { return decode_bc7_block(block); }, code_at);
      return;
    default:
      assert(false && "a format without samples");
  }
}

}  // namespace vt::store
