#include "builder/pipeline/plan_cost.h"

#include <algorithm>
#include <string>

namespace vt::pipeline {

PlanCost plan_cost(const LayerInfo& info) {
  PlanCost cost;
  for (int level = 0; level <= info.finest.value; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect data = info.data_rect(l);
    const TexelRect tiles = info.tile_rect(l);
    cost.texels += static_cast<std::uint64_t>(data.width) * static_cast<std::uint64_t>(data.height);
    cost.tiles += static_cast<std::uint64_t>(tiles.width) * static_cast<std::uint64_t>(tiles.height);
  }
  cost.raw_bytes = cost.tiles * info.tile_payload_bytes();
  return cost;
}

}  // namespace vt::pipeline
