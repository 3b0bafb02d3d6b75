// The BC6H encoder's method for one block, without vectors: the truth to which every CPU target is held, bit
// for bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "builder/encode/quality.h"

namespace vt::encode {

// `halves` as in the source: any bits.
using HalfTexels = std::array<std::array<std::uint16_t, 3>, 16>;
[[nodiscard]] std::array<std::byte, 16> encode_bc6h_block_by_definition(const HalfTexels& halves, Quality quality);

}  // namespace vt::encode
