// Which cascade a channel's planes need.
#pragma once

#include <memory>
#include <vector>

#include "builder/pyramid/cascade.h"

namespace vt::pyramid {

// Levels as from plan_block(), of `layer`; levels[0].active is not empty. Tiles of carry are 2^tile_exponent
// texels a side, areas of classes are counted in 1 / 2^area_exponent of a texel of the finest level. The
// codec is used during the call only.
[[nodiscard]] std::unique_ptr<Cascade> make_cascade(std::vector<BlockLevel> levels, const LayerShape& layer, int outputs,
                                                    const channels::ChannelCodec& codec, const HalvingKernel& kernel, int tile_exponent,
                                                    int area_exponent);

}  // namespace vt::pyramid
