#include "builder/pyramid/cascade.h"

#include <algorithm>

namespace vt::pyramid {

std::vector<BlockLevel> plan_block(const TexelRect& core, const TexelRect& data, int outputs, bool with_carry,
                                   const HalvingKernel& kernel) {
  const int count = outputs + (with_carry ? 1 : 0);
  std::vector<BlockLevel> levels(static_cast<std::size_t>(count));
  std::int64_t apron = 0;
  for (int k = count - 1; k >= 0; --k) {
    // A level that becomes texels needs one more texel around it, for colour borrowed from neighbours; a carry level does not.
    if (k < outputs) apron = std::max<std::int64_t>(apron, 1);
    BlockLevel& level = levels[static_cast<std::size_t>(k)];
    const TexelRect core_k{core.x >> k, core.y >> k, core.width >> k, core.height >> k};
    level.data = coarser(data, k);
    level.core = intersect(core_k, level.data);
    level.active = intersect(grown(core_k, apron), level.data);
    apron = 2 * apron + kernel.reach();  // what the next finer level must have around its core
  }
  return levels;
}

}  // namespace vt::pyramid
