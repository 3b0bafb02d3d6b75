// Texels of any format as plain numbers, and blocks as texels of a plain format, so that nobody else needs a
// switch over formats. Owns no rules of a channel: a sample becomes a value through the layer's component
// ranges (store/layer.h). Pure functions, any thread.
#pragma once

#include <cstddef>
#include <span>

#include "store/texel_format.h"

namespace vt::store {

// `payload` is payload_bytes(width, height) of a format that is not kOpaque; `out` gets width * height *
// channels samples, row by row, channels interleaved. A sample is the code in unorm formats, the decoded
// value on the scale of 0 to 255 in bc1, bc3, bc4, bc5 and bc7 (whole in colours and alpha, with fractions in
// bc4 and bc5), and the number itself in half, float, rgb9e5 and bc6h. All of it is exact.
void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out);

// A width x height image (multiples of 4) of a block format into texels of format_info(format).decoded_to,
// row by row: for a graphics card that does not take the blocks. To the nearest code where a decoded value
// lies between two.
void decode_blocks(TexelFormat format, std::span<const std::byte> blocks, std::size_t width, std::size_t height, std::span<std::byte> out);

}  // namespace vt::store
