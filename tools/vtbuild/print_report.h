// What vtbuild says when a layer is done: for people, and as JSON for programs
// (schemas/vtbuild-report.schema.json).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "builder/pipeline/build/layer_build.h"
#include "builder/pipeline/plan/layer_plan.h"

namespace vt::tools {

// "layer color: color as rgb8, ..."
[[nodiscard]] std::string layer_line(const pipeline::LayerPlan& plan);

void print_report(const pipeline::LayerPlan& plan, const pipeline::BuildReport& report, bool with_stats);
[[nodiscard]] nlohmann::ordered_json report_json(const pipeline::LayerPlan& plan, const pipeline::BuildReport& report, bool with_stats);
// What --json prints: the layers of one run, as report_json() gave them.
[[nodiscard]] nlohmann::ordered_json report_document(const std::string& store, nlohmann::ordered_json layers);

}  // namespace vt::tools
