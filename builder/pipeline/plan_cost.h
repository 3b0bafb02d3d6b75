// What building a planned layer costs: memory, tiles, bytes. Arithmetic only; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/pipeline/layer_plan.h"
#include "store/result.h"

namespace vt::pipeline {

// Figures for --dry-run.
struct PlanCost {
  std::uint64_t texels = 0;  // of all levels, data only
  std::uint64_t tiles = 0;
  std::uint64_t raw_bytes = 0;
};
[[nodiscard]] PlanCost plan_cost(const LayerInfo& info);

}  // namespace vt::pipeline
