// Which cascade a channel's planes need.
#pragma once

#include <memory>
#include <vector>

#include "builder/pyramid/cascade.h"

namespace vt::pyramid {

// Levels as from plan_block(); levels[0].active is not empty and lies `depth` levels above the layer's finest. Tiles of carry are
// 2^tile_exponent texels a side. The codec is used during the call only.
[[nodiscard]] std::unique_ptr<Cascade> make_cascade(std::vector<BlockLevel> levels, int outputs, const channels::ChannelCodec& codec,
                                                    const HalvingKernel& kernel, int depth, int tile_exponent);

}  // namespace vt::pyramid
