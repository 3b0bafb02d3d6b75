// Any payload as numbers: what tools show, tests compare and the builder measures. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <span>

#include "store/texel_format.h"

namespace vt::store {

// The samples of `width` x `height` texels (multiples of the block edge), rows from the north, channels interleaved: integer codes as they
// are (0..255; of block formats the decoded value on that scale), floats as they are. `payload` has exactly their size, `out` room for
// width * height * channels. Not for hash128 and blob.
void decode_texels(TexelFormat format, std::span<const std::byte> payload, std::size_t width, std::size_t height, std::span<float> out);

}  // namespace vt::store
