#include "tools/vtbuild/print_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "builder/channels/all_channels.h"
#include "tools/cli/cli_support.h"

namespace vt::tools {
namespace {

using pipeline::BuildReport;
using pipeline::Stage;

double megapixels_per_second(const BuildReport& report) {
  return report.seconds > 0.0 ? static_cast<double>(report.base_texels) / 1e6 / report.seconds : 0.0;
}

// Threads times wall time, less what the workers account for: starting, planning the blocks, the last commit.
double unaccounted_seconds(const BuildReport& report) {
  double sum = 0.0;
  for (const double seconds : report.stages.seconds) sum += seconds;
  return std::max(0.0, report.seconds * report.threads - sum);
}

void print_stats(const BuildReport& report) {
  const double all = report.seconds * report.threads;
  cli::print(fmt::format("  where the time of {} threads went ({:.2f} s each):\n", report.threads, report.seconds));
  const auto line = [&](std::string_view name, double seconds) {
    if (seconds <= 0.0) return;
    const double share = all > 0.0 ? seconds / all : 0.0;
    cli::print(fmt::format("    {:<9} {:>8.2f} s {:>5.1f} %  {}\n", name, seconds, 100.0 * share,
                           std::string(static_cast<std::size_t>(40.0 * share + 0.5), '#')));
  };
  for (std::size_t i = 0; i < pipeline::kStageCount; ++i)
    line(pipeline::stage_name(static_cast<Stage>(i)), report.stages.of(static_cast<Stage>(i)));
  line("other", unaccounted_seconds(report));
  cli::print(fmt::format("    beside them, {:.2f} s of checkpoints and the last commit\n", report.commit_seconds));
}

}  // namespace

std::string layer_line(const pipeline::LayerPlan& plan) {
  const LayerInfo& info = plan.info;
  return fmt::format("layer {}: {} as {}, {} x {} texels, {} levels, tiles of {}, kernel {}, {}", info.name,
                     channels::channel_name(info.channel), format_info(info.format).name, info.data.width, info.data.height,
                     info.finest.value + 1, info.tile_texels(), plan.kernel.name, plan.request.compression);
}

void print_report(const pipeline::LayerPlan& plan, const BuildReport& report, bool with_stats) {
  cli::print(layer_line(plan) + "\n");
  if (report.blocks_checked > 0)
    cli::print(fmt::format("  {} of {} blocks have other sources than before\n", report.blocks_changed, report.blocks_checked));
  if (report.was_complete) {
    cli::print("  already complete, nothing to do\n");
  } else {
    cli::print(fmt::format("  {} tiles ({} of one value), {} in the store; {:.2f} s, {:.1f} Mpx/s, {} threads\n", report.tiles,
                           report.constant_tiles, cli::format_bytes(report.stored_bytes), report.seconds, megapixels_per_second(report),
                           report.threads));
    if (report.blocks_checked > 0)
      cli::print(fmt::format("  {} blocks built; tiles: {} written, {} as they were, {} removed\n", report.blocks_built,
                             report.tile_counts.written, report.tile_counts.unchanged, report.tile_counts.removed));
    else if (report.blocks_resumed > 0)
      cli::print(fmt::format("  {} of {} blocks were there from an earlier run\n", report.blocks_resumed,
                             report.blocks_resumed + report.blocks_built));
  }
  if (with_stats) print_stats(report);
}

nlohmann::ordered_json report_json(const pipeline::LayerPlan& plan, const BuildReport& report, bool with_stats) {
  nlohmann::ordered_json json;
  json["name"] = plan.info.name;
  json["channel"] = channels::channel_name(plan.info.channel);
  json["format"] = format_info(plan.info.format).name;
  json["kernel"] = plan.kernel.name;
  json["compression"] = plan.request.compression;
  json["width"] = plan.info.data.width;
  json["height"] = plan.info.data.height;
  json["levels"] = plan.info.finest.value + 1;
  json["was_complete"] = report.was_complete;
  json["seconds"] = report.seconds;
  json["threads"] = report.threads;
  json["megapixels_per_second"] = megapixels_per_second(report);
  json["tiles"] = report.tiles;
  json["constant_tiles"] = report.constant_tiles;
  json["stored_bytes"] = report.stored_bytes;
  json["block_texels"] = std::int64_t{plan.info.tile_texels()} << report.block_levels;
  json["blocks"] = {{"built", report.blocks_built},
                    {"resumed", report.blocks_resumed},
                    {"checked", report.blocks_checked},
                    {"changed", report.blocks_changed}};
  json["tile_changes"] = {
      {"written", report.tile_counts.written}, {"unchanged", report.tile_counts.unchanged}, {"removed", report.tile_counts.removed}};
  json["warnings"] = plan.warnings;
  for (const std::string& remark : report.remarks) json["warnings"].push_back(remark);
  if (with_stats) {
    nlohmann::ordered_json stages;
    for (std::size_t i = 0; i < pipeline::kStageCount; ++i)
      stages[std::string(pipeline::stage_name(static_cast<Stage>(i)))] = report.stages.of(static_cast<Stage>(i));
    stages["other"] = unaccounted_seconds(report);
    json["stage_seconds"] = std::move(stages);
    json["commit_seconds"] = report.commit_seconds;
  }
  return json;
}

nlohmann::ordered_json report_document(const std::string& store, nlohmann::ordered_json layers) {
  return {{"store", store}, {"layers", std::move(layers)}};
}

}  // namespace vt::tools
