// A tile of carry of planes, as bytes that a compressor shortens well: for each plane the residuals of its
// floats against the gradient of their neighbours (store/codec/prediction.h), reversible to the bit. Pure
// functions, any thread.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "store/result.h"

namespace vt::pyramid {

// `floats` holds `planes` squares of edge * edge values, plane after plane.
void pack_carry(std::span<const float> floats, std::size_t planes, std::size_t edge, std::vector<std::byte>& out);
// The way back. kCorrupt: not the bytes of so many planes.
[[nodiscard]] Result<void> unpack_carry(std::span<const std::byte> bytes, std::size_t planes, std::size_t edge, std::span<float> floats);

}  // namespace vt::pyramid
