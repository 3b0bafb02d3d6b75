// What vtbuild --dry-run says: for people, and as JSON for programs (schemas/build-plan.schema.json).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "builder/pipeline/plan/layer_plan.h"

namespace CLI {
class App;
}

namespace vt::tools {

// What all layers of a run share.
struct PlanContext {
  int threads = 1;
  std::size_t memory_bytes = 0;
  double megatexels_per_second = 0.0;  // 0: not given
  const CLI::App* command = nullptr;   // whose flags the texts name; nullptr: settings keep their own names
};

void print_plan(const pipeline::LayerPlan& plan, int block_levels, const PlanContext& context);

// The document for layers with the block sizes of the same order.
[[nodiscard]] nlohmann::ordered_json plan_json(const std::filesystem::path& store, const std::vector<pipeline::LayerPlan>& plans,
                                               const std::vector<int>& block_levels, const PlanContext& context);

// One document of several of the same run: a store whose layers were asked for one by one.
[[nodiscard]] nlohmann::ordered_json joined_plans(std::vector<nlohmann::ordered_json> documents);

// Notes on plans that cannot be carried out as they are.
[[nodiscard]] std::vector<std::string> plan_doubts(const std::vector<pipeline::LayerPlan>& plans, const std::vector<int>& block_levels,
                                                   const PlanContext& context);

}  // namespace vt::tools
