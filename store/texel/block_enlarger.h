// Blocks of a coarser level in the place of finer ones that are absent, without leaving the compressed
// format: what read_region() fills holes of block formats with. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "store/texel_format.h"

namespace vt::store {

// Makes `fine`, the block in column x and row y of a level, from `coarse`, the block that covers it `steps`
// levels further up; steps is at least 1, and both spans are one block of `format` long. bc1 and bc3 to bc5
// are exact: the end points stay, in their order, so that the mode which they choose stays. bc6h and bc7 are
// exact from 2 steps on, and otherwise the mean of the 2 x 2 texels under the block.
void enlarge_block(TexelFormat format, std::span<const std::byte> coarse, std::int64_t x, std::int64_t y, int steps,
                   std::span<std::byte> fine);

}  // namespace vt::store
