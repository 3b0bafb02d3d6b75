// Any rectangle of any level of a layer as one block of texels, whatever the tiling on disk; holes are filled
// from coarser levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"

namespace vt::store {

// How much of a region came from its own level.
struct RegionReport {
  std::uint64_t texels_own_level = 0;
  std::uint64_t texels_from_coarser = 0;  // replicated from the nearest ancestor that is present
  std::uint64_t texels_missing = 0;       // not even the root has them: written as zero bytes (NaN for halves and floats)
};

// Fills `out`, in the layer's own format, with `rect` of `level`. For block formats x, y, width and height
// are multiples of 4, and holes are filled in the compressed domain: bc1 and bc3 to bc5 exactly, a coarser
// texel enlarged 2^k times keeping its block's end points; bc7 and bc6h exactly where k > 1, and with the
// mean of 2 x 2 coarser texels where k is 1. `row_pitch_bytes` is from one row of blocks to the next; 0 means
// tightly packed. Rectangles may reach outside the padded square: those texels are missing.
[[nodiscard]] Result<RegionReport> read_region(const StoreReader& reader, LayerId layer, Level level, const TexelRect& rect,
                                               std::span<std::byte> out, std::size_t row_pitch_bytes = 0);

}  // namespace vt::store
