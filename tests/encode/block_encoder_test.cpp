// Every block format has its encoder, which takes the plain format that the format's row names.
#include "builder/encode/block_encoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "store/io/bytes.h"
#include "store/texel/half.h"
#include "store/texel/texel_decoder.h"

namespace vt::encode {
namespace {

// One number in all channels of a plain format: `share` of the greatest code, or the number itself.
std::vector<std::byte> texels_of(const FormatInfo& plain, std::size_t texels, float share) {
  std::vector<std::byte> bytes(texels * plain.block_bytes);
  for (std::size_t i = 0; i < texels * plain.channels; ++i) {
    switch (plain.samples) {
      case SampleKind::kUnorm8:
        bytes[i] = static_cast<std::byte>(std::lround(share * 255.0F));
        break;
      case SampleKind::kUnorm16:
        store::put<std::uint16_t>(bytes, 2 * i, static_cast<std::uint16_t>(std::lround(share * 65535.0F)));
        break;
      case SampleKind::kHalf:
        store::put<std::uint16_t>(bytes, 2 * i, half_from_float(share));
        break;
      case SampleKind::kFloat:
      case SampleKind::kSharedExponent:
      case SampleKind::kBlock:
      case SampleKind::kOpaque:
        ADD_FAILURE() << plain.name << " is nothing that an encoder takes";
        return bytes;
    }
  }
  return bytes;
}

TEST(BlockEncoder, EveryBlockFormatIsEncodedFromThePlainFormatOfItsRow) {
  constexpr std::size_t kEdge = 8;
  for (const FormatInfo& info : kTexelFormats) {
    if (!is_block_format(info)) continue;
    const FormatInfo& plain = format_info(info.encoded_from);
    const std::vector<std::byte> texels = texels_of(plain, kEdge * kEdge, 0.75F);
    std::vector<std::byte> blocks(payload_bytes(info, kEdge, kEdge), std::byte{0xEE});
    encode_blocks(info.format, texels, kEdge, kEdge, kEdge * plain.block_bytes, Quality::kNormal, blocks);
    std::vector<float> samples(kEdge * kEdge * info.channels);
    store::decode_texels(info.format, blocks, kEdge, kEdge, samples);
    const bool is_number = plain.samples == SampleKind::kHalf;
    // Colours of bc1 and bc3 have end points of 5 and 6 bits: half a step of 5 bits, less a little for the
    // thirds between.
    for (const float sample : samples) EXPECT_NEAR(sample, is_number ? 0.75 : 0.75 * 255, is_number ? 0.01 : 4.5) << info.name;
  }
}

}  // namespace
}  // namespace vt::encode
