// What building a planned layer costs: memory, tiles, bytes. Arithmetic only; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/pipeline/layer_plan.h"
#include "store/result.h"

namespace vt::pipeline {

// Resident bytes that one worker needs for a block of that size.
[[nodiscard]] std::size_t worker_bytes(const LayerPlan& plan, int levels);

// The largest block (2^levels tiles) that fits `threads` workers into `memory_bytes`, at most 4096 texels wide. kUsage when not even the
// smallest does.
[[nodiscard]] Result<int> choose_block_levels(const LayerPlan& plan, int threads, std::size_t memory_bytes);

// Figures for --dry-run.
struct PlanCost {
  std::uint64_t texels = 0;  // of all levels, data only
  std::uint64_t tiles = 0;
  std::uint64_t raw_bytes = 0;
};
[[nodiscard]] PlanCost plan_cost(const LayerInfo& info);

}  // namespace vt::pipeline
