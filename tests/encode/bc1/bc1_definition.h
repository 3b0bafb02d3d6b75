// The encoder's method for one block, without vectors: the truth to which every CPU target is held, bit for
// bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace vt::encode {

using BlockTexels = std::array<std::array<int, 3>, 16>;
[[nodiscard]] std::array<std::byte, 8> encode_block_by_definition(const BlockTexels& texels);

// Squared error of a plain least-squares encoder: extremes of the principal axis, then eight rounds of
// nearest palette entry and least squares in double, each end point rounded by itself; the best round counts.
// No table for flat blocks, no joint rounding.
[[nodiscard]] int plain_least_squares_error(const BlockTexels& texels);

}  // namespace vt::encode
