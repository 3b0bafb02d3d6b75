#include "builder/pipeline/plan_cost.h"

#include <algorithm>
#include <string>

namespace vt::pipeline {

std::size_t worker_bytes(const LayerPlan& plan, int levels) {
  const auto tile = static_cast<std::size_t>(plan.info.tile_texels());
  const auto planes = static_cast<std::size_t>(plan.sampler->codec().planes());
  const std::size_t texel = format_info(plan.sampler->codec().texel_format()).block_bytes;
  const std::size_t width = (tile << levels) + static_cast<std::size_t>(plan.kernel.reach() * 2) * ((std::size_t{1} << levels) - 1) + 64;
  const std::size_t ring =
      static_cast<std::size_t>(plan.kernel.taps + 4) * planes * width * sizeof(float) * 2;  // all levels: twice the base
  const std::size_t bands = 2 * tile * width * texel;
  const std::size_t payloads = bands / 2;                               // tiles on their way into the store
  const std::size_t chunk = 64 * width * (planes + 2) * sizeof(float);  // source rows, or a carry band
  const std::size_t carry = tile * width * planes * sizeof(float) / (plan.info.finest.value >= levels ? 1 : 4);
  return ring + bands + payloads + chunk + carry;
}

Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes) {
  const int widest = std::max(1, 12 - int{plan.info.tile_exponent});
  const std::size_t fixed = std::size_t{24} << 20;  // program, libraries, the store's index pages
  for (int levels = widest; levels >= 1; --levels)
    if (fixed + static_cast<std::size_t>(threads) * worker_bytes(plan, levels) <= memory_bytes) return levels;
  const std::size_t least = fixed + static_cast<std::size_t>(threads) * worker_bytes(plan, 1);
  return fail(ErrorCode::kUsage, "--memory " + std::to_string(memory_bytes >> 20) + "M is too little for " + std::to_string(threads) +
                                     " threads; this layer needs at least " + std::to_string((least >> 20) + 1) + "M, or fewer --threads");
}

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
