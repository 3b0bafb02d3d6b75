// The BC7 encoder's method for one block, without vectors: the truth to which every CPU target is held, bit
// for bit.
#pragma once

#include <array>
#include <cstddef>

#include "builder/encode/quality.h"

namespace vt::encode {

using RgbaTexels = std::array<std::array<int, 4>, 16>;
[[nodiscard]] std::array<std::byte, 16> encode_bc7_block_by_definition(const RgbaTexels& texels, Quality quality);

}  // namespace vt::encode
