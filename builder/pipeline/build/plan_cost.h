// How much a planned layer makes: texels, tiles, bytes, blocks, time. Counts are exact for data without
// holes; an estimate says what it rests on. Arithmetic only, however large the layer; any thread.
#pragma once

#include <cstdint>
#include <string>

#include "builder/pipeline/plan/layer_plan.h"

namespace vt::pipeline {

struct PlanCost {
  std::uint64_t texels = 0;  // of all levels, data only
  std::uint64_t tiles = 0;
  std::uint64_t raw_bytes = 0;
};
[[nodiscard]] PlanCost plan_cost(const LayerInfo& info);
// The cost of all parts of a layer. Texels count once.
[[nodiscard]] PlanCost plan_cost(const LayerPlan& plan);

struct PlanEstimate {
  double tile_ratio = 1.0;  // stored bytes of a tile to raw ones
  std::uint64_t tile_bytes = 0;
  std::uint64_t working_state_bytes = 0;  // carry and block marks
  std::uint64_t index_bytes = 0;          // of tiles and working state
  std::uint64_t file_bytes = 0;           // all of these, with the headers of records
  double megatexels_per_second = 0.0;     // of the finest level, all threads together
  double seconds = 0.0;
  std::string basis;
};

// What a thread does when nobody says otherwise: colour by kaiser3 to zstd:3 on a machine of 2020 or so.
inline constexpr double kMegatexelsPerThreadSecond = 10.0;

// `megatexels_per_second` 0: by the number of threads.
[[nodiscard]] PlanEstimate estimate_cost(const LayerPlan& plan, int block_levels, int threads, double megatexels_per_second);

}  // namespace vt::pipeline
