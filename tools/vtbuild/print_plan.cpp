#include "tools/vtbuild/print_plan.h"

#include <fmt/format.h>

#include <numeric>
#include <string>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/build/build_memory.h"
#include "builder/pipeline/build/plan_cost.h"
#include "store/format/layout.h"
#include "tools/cli/cli_support.h"
#include "tools/cli/setting_names.h"
#include "tools/vtbuild/print_report.h"

namespace vt::tools {
namespace {

using Json = nlohmann::ordered_json;

std::int64_t all_blocks(const std::vector<pipeline::Tier>& tiers) {
  return std::accumulate(tiers.begin(), tiers.end(), std::int64_t{0},
                         [](std::int64_t sum, const pipeline::Tier& tier) { return sum + tier.blocks(); });
}

std::string basis_of(const pipeline::PlanEstimate& estimate, const PlanContext& context) {
  return context.command == nullptr ? estimate.basis : cli::with_flags(estimate.basis, *context.command);
}

Json levels_json(const LayerInfo& info) {
  Json levels = Json::array();
  for (int level = info.finest.value; level >= 0; --level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect data = info.data_rect(l);
    const TexelRect tiles = info.tile_rect(l);
    levels.push_back(
        {{"level", level}, {"width", data.width}, {"height", data.height}, {"tiles_across", tiles.width}, {"tiles_down", tiles.height}});
  }
  return levels;
}

Json layer_json(const pipeline::LayerPlan& plan, int block_levels, const PlanContext& context) {
  const LayerInfo& info = plan.info;
  const pipeline::PlanCost cost = pipeline::plan_cost(plan);
  const pipeline::PlanEstimate estimate = pipeline::estimate_cost(plan, block_levels, context.threads, context.megatexels_per_second);
  const pipeline::BuildMemory memory = pipeline::build_memory(plan, block_levels, context.threads);
  const std::vector<pipeline::Tier> tiers = pipeline::plan_tiers(info, block_levels);
  const Area area = plan.extent();
  Json json;
  json["name"] = info.name;
  json["channel"] = channels::channel_name(info.channel);
  json["format"] = format_info(info.format).name;
  json["kernel"] = plan.kernel.name;
  json["compression"] = plan.request.compression;
  json["resample"] = resample::method_name(plan.resampling);
  json["crs"] = plan.crs.text();
  json["extent"] = {{"west", area.west}, {"south", area.south}, {"east", area.east}, {"north", area.north}};
  json["texel_size"] = {info.grid.step_x, info.grid.step_y};
  json["width"] = info.data.width;
  json["height"] = info.data.height;
  json["sources"] = {{"count", plan.request.sources.size()}, {"are_there", plan.sampler != nullptr}};
  json["levels"] = levels_json(info);
  json["texels"] = cost.texels;
  json["tiles"] = cost.tiles;
  json["raw_bytes"] = cost.raw_bytes;
  json["estimate"] = {{"tile_bytes", estimate.tile_bytes},
                      {"tile_ratio", estimate.tile_ratio},
                      {"working_state_bytes", estimate.working_state_bytes},
                      {"index_bytes", estimate.index_bytes},
                      {"file_bytes", estimate.file_bytes},
                      {"seconds", estimate.seconds},
                      {"megatexels_per_second", estimate.megatexels_per_second},
                      {"basis", basis_of(estimate, context)}};
  Json tier_list = Json::array();
  for (const pipeline::Tier& tier : tiers) tier_list.push_back({{"base_level", tier.base.value}, {"blocks", tier.blocks()}});
  json["work"] = {{"block_texels", tiers.front().block_texels}, {"blocks", all_blocks(tiers)}, {"tiers", std::move(tier_list)}};
  json["memory"] = {{"program", memory.program},
                    {"sources", memory.sources},
                    {"store", memory.store},
                    {"worker", memory.worker},
                    {"total", memory.total(context.threads)}};
  return json;
}

}  // namespace

void print_plan(const pipeline::LayerPlan& plan, int block_levels, const PlanContext& context) {
  const LayerInfo& info = plan.info;
  const pipeline::PlanCost cost = pipeline::plan_cost(plan);
  const pipeline::PlanEstimate estimate = pipeline::estimate_cost(plan, block_levels, context.threads, context.megatexels_per_second);
  const pipeline::BuildMemory memory = pipeline::build_memory(plan, block_levels, context.threads);
  const std::vector<pipeline::Tier> tiers = pipeline::plan_tiers(info, block_levels);
  const auto line = [](std::string_view name, const std::string& text) { cli::print(fmt::format("  {:<12} {}\n", name, text)); };
  cli::print(layer_line(plan) + "\n");
  line("crs", plan.crs.text());
  const Area area = plan.extent();
  line("extent", fmt::format("west {} south {} east {} north {}", cli::format_exact(area.west), cli::format_exact(area.south),
                             cli::format_exact(area.east), cli::format_exact(area.north)));
  line("texel size", fmt::format("{} x {} CRS units", cli::format_exact(info.grid.step_x), cli::format_exact(info.grid.step_y)));
  for (int level = info.finest.value; level >= 0; --level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect data = info.data_rect(l);
    const TexelRect tiles = info.tile_rect(l);
    line(fmt::format("level {:>2}", level),
         fmt::format("{} x {} texels, {} x {} tiles", data.width, data.height, tiles.width, tiles.height));
  }
  line("in all", fmt::format("{} texels, {} tiles, {} before compression and without savings for constant tiles",
                             cli::format_quantity(static_cast<double>(cost.texels)), cost.tiles, cli::format_bytes(cost.raw_bytes)));
  line("file", fmt::format("about {}: tiles {} ({:.0f} %), index {}, working state for updates {}", cli::format_bytes(estimate.file_bytes),
                           cli::format_bytes(estimate.tile_bytes), 100.0 * estimate.tile_ratio, cli::format_bytes(estimate.index_bytes),
                           cli::format_bytes(estimate.working_state_bytes)));
  line("time", fmt::format("about {} at {} texels a second", cli::format_duration(estimate.seconds),
                           cli::format_quantity(estimate.megatexels_per_second * 1e6)));
  line("estimated by", basis_of(estimate, context));
  line("work", fmt::format("{} blocks of {} x {} texels on {} threads, at most {} of {} memory", all_blocks(tiers),
                           tiers.front().block_texels, tiers.front().block_texels, context.threads,
                           cli::format_bytes(memory.total(context.threads)), cli::format_bytes(context.memory_bytes)));
  line("memory", fmt::format("program {}, sources {}, store {}, each thread {}", cli::format_bytes(memory.program),
                             cli::format_bytes(memory.sources), cli::format_bytes(memory.store), cli::format_bytes(memory.worker)));
}

Json plan_json(const std::filesystem::path& store, const std::vector<pipeline::LayerPlan>& plans, const std::vector<int>& block_levels,
               const PlanContext& context) {
  Json document;
  document["store"] = store.string();
  document["threads"] = context.threads;
  document["memory_limit_bytes"] = context.memory_bytes;
  document["layers"] = Json::array();
  document["warnings"] = Json::array();
  std::uint64_t tiles = 0;
  std::uint64_t raw_bytes = 0;
  std::uint64_t file_bytes = 0;
  double seconds = 0.0;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    Json layer = layer_json(plans[i], block_levels[i], context);
    tiles += layer["tiles"].get<std::uint64_t>();
    raw_bytes += layer["raw_bytes"].get<std::uint64_t>();
    file_bytes += layer["estimate"]["file_bytes"].get<std::uint64_t>();
    seconds += layer["estimate"]["seconds"].get<double>();
    document["layers"].push_back(std::move(layer));
    for (const std::string& warning : plans[i].warnings) document["warnings"].push_back(warning);
  }
  for (const std::string& doubt : plan_doubts(plans, block_levels, context)) document["warnings"].push_back(doubt);
  document["total"] = {{"tiles", tiles}, {"raw_bytes", raw_bytes}, {"estimate", {{"file_bytes", file_bytes}, {"seconds", seconds}}}};
  return document;
}

Json joined_plans(std::vector<Json> documents) {
  Json all = std::move(documents.front());
  for (std::size_t i = 1; i < documents.size(); ++i) {
    const Json& more = documents[i];
    for (const char* list : {"layers", "warnings"})
      for (const Json& one : more[list]) all[list].push_back(one);
    Json& total = all["total"];
    for (const char* sum : {"tiles", "raw_bytes"}) total[sum] = total[sum].get<std::uint64_t>() + more["total"][sum].get<std::uint64_t>();
    Json& estimate = total["estimate"];
    const Json& more_estimate = more["total"]["estimate"];
    estimate["file_bytes"] = estimate["file_bytes"].get<std::uint64_t>() + more_estimate["file_bytes"].get<std::uint64_t>();
    estimate["seconds"] = estimate["seconds"].get<double>() + more_estimate["seconds"].get<double>();
  }
  return all;
}

std::vector<std::string> plan_doubts(const std::vector<pipeline::LayerPlan>& plans, const std::vector<int>& block_levels,
                                     const PlanContext& context) {
  std::vector<std::string> doubts;
  double file_bytes = 0.0;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    file_bytes += static_cast<double>(pipeline::estimate_cost(plans[i], block_levels[i], context.threads, 0.0).file_bytes);
    const std::size_t memory = pipeline::build_memory(plans[i], block_levels[i], context.threads).total(context.threads);
    if (memory > context.memory_bytes)
      doubts.push_back(fmt::format("layer '{}' may take {} with {} threads, more than --memory {}", plans[i].info.name,
                                   cli::format_bytes(memory), context.threads, cli::format_bytes(context.memory_bytes)));
  }
  if (file_bytes > static_cast<double>(store::kMaxFileBytes))
    doubts.push_back(fmt::format("about {} are more than the {} that one store can hold: build the area in parts",
                                 cli::format_bytes(static_cast<std::uint64_t>(file_bytes)), cli::format_bytes(store::kMaxFileBytes)));
  return doubts;
}

}  // namespace vt::tools
