#include "builder/encode/block_encoder.h"

#include <array>
#include <cassert>

#include "builder/encode/bc1/bc1_encoder.h"
#include "builder/encode/bc1/bc3_encoder.h"
#include "builder/encode/bc4/bc4_encoder.h"
#include "builder/encode/bptc/bc6h_encoder.h"
#include "builder/encode/bptc/bc7_encoder.h"

namespace vt::encode {
namespace {

void encode_bc1_of_rgb8(std::span<const std::byte> texels, std::size_t width, std::size_t height, std::size_t row_pitch_bytes,
                        Quality quality, std::span<std::byte> blocks) {
  encode_bc1_image(texels, width, height, row_pitch_bytes, 3, quality, blocks);
}

struct Encoder {
  TexelFormat format;
  void (*encode)(std::span<const std::byte> texels, std::size_t width, std::size_t height, std::size_t row_pitch_bytes, Quality quality,
                 std::span<std::byte> blocks);
};
constexpr std::array kEncoders = {
    Encoder{TexelFormat::kBc1, encode_bc1_of_rgb8}, Encoder{TexelFormat::kBc3, encode_bc3_image},
    Encoder{TexelFormat::kBc4, encode_bc4_image},   Encoder{TexelFormat::kBc5, encode_bc5_image},
    Encoder{TexelFormat::kBc6h, encode_bc6h_image}, Encoder{TexelFormat::kBc7, encode_bc7_image},
};
static_assert(has_one_row_each(kEncoders, is_block_format));

}  // namespace

void encode_blocks(TexelFormat format, std::span<const std::byte> texels, std::size_t width, std::size_t height,
                   std::size_t row_pitch_bytes, Quality quality, std::span<std::byte> blocks) {
  row_of(kEncoders, format).encode(texels, width, height, row_pitch_bytes, quality, blocks);
}

}  // namespace vt::encode
