#include "builder/pipeline/build/plan_cost.h"

#include <cmath>

#include "builder/channels/all_channels.h"
#include "builder/pipeline/blocks/block_quality.h"
#include "store/format/layout.h"

namespace vt::pipeline {
namespace {

double tile_ratio(const LayerPlan& plan, TexelFormat format) {
  return plan.compression.codec == store::Codec::kRaw ? 1.0 : channels::kind_of(plan.info.channel).stored_ratio(format);
}

std::uint64_t scaled(std::uint64_t bytes, double ratio) {
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(bytes) * ratio));
}

// Entries and the heads of their pages, one page for 1024 tiles side by side, and about a thirtieth for the
// pages above.
std::uint64_t index_bytes_of(std::uint64_t entries) {
  const std::uint64_t pages = entries / store::kPageSlots + 1;
  return entries * store::kReferenceBytes + pages * (store::kPageEntriesAt + store::kRecordHeaderBytes) * 31 / 30;
}

PlanCost cost_of_levels(const LayerInfo& info, int finest) {
  PlanCost cost;
  for (int level = 0; level <= finest; ++level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const TexelRect data = info.data_rect(l);
    const TexelRect tiles = info.tile_rect(l);
    cost.texels += static_cast<std::uint64_t>(data.width) * static_cast<std::uint64_t>(data.height);
    cost.tiles += static_cast<std::uint64_t>(tiles.width) * static_cast<std::uint64_t>(tiles.height);
  }
  cost.raw_bytes = cost.tiles * info.tile_payload_bytes();
  return cost;
}

// One that ends at the base has its other levels from a pass after the blocks.
PlanCost cost_of_part(const LayerPlan& plan, std::size_t part) {
  return cost_of_levels(plan.parts[part], plan.info.finest.value - (plan.part(part).starts_above_base ? 1 : 0));
}

}  // namespace

PlanCost plan_cost(const LayerInfo& info) { return cost_of_levels(info, info.finest.value); }

PlanCost plan_cost(const LayerPlan& plan) {
  PlanCost cost;
  cost.texels = plan_cost(plan.info).texels;
  for (std::size_t i = 0; i < plan.parts.size(); ++i) {
    const PlanCost part = cost_of_part(plan, i);
    cost.tiles += part.tiles;
    cost.raw_bytes += part.raw_bytes;
  }
  return cost;
}

PlanEstimate estimate_cost(const LayerPlan& plan, int block_levels, int threads, double megatexels_per_second) {
  const PlanCost cost = plan_cost(plan);
  PlanEstimate estimate;
  bool all_are_measured = true;
  for (std::size_t i = 0; i < plan.parts.size(); ++i) {
    const PlanCost part = cost_of_part(plan, i);
    const double ratio = tile_ratio(plan, plan.parts[i].format);
    all_are_measured = all_are_measured && ratio != channels::kUnmeasuredRatio;
    estimate.tile_bytes += scaled(part.raw_bytes, ratio);
    estimate.index_bytes += index_bytes_of(part.tiles);
  }
  if (cost.raw_bytes > 0) estimate.tile_ratio = static_cast<double>(estimate.tile_bytes) / static_cast<double>(cost.raw_bytes);

  // Every block leaves what was measured of it, every one but the last a tile of carry and a mark.
  std::uint64_t kept_blocks = 0;
  std::uint64_t blocks = 0;
  std::uint64_t quality_bytes = 0;
  const std::vector<Tier> tiers = plan_tiers(plan.info, block_levels);
  for (std::size_t i = 0; i < tiers.size(); ++i) {
    const Tier& tier = tiers[i];
    const auto tier_blocks = static_cast<std::uint64_t>(tier.blocks());
    if (tier.has_carry) kept_blocks += tier_blocks;
    blocks += tier_blocks;
    quality_bytes += tier_blocks * block_quality_bytes(quality_shape(*plan.codec, i, tier.outputs));
  }
  if (quality_bytes == 0) blocks = 0;  // nothing is measured, nothing is left
  const std::uint64_t carry_tile =
      std::uint64_t{plan.info.tile_texels()} * plan.info.tile_texels() * static_cast<std::uint64_t>(plan.codec->planes()) * sizeof(float);
  const double carry_ratio = channels::kind_of(plan.info.channel).carry_ratio;
  constexpr std::uint64_t kRecordBytes = store::kRecordHeaderBytes + store::kRecordAlignment / 2;  // header, and up to the next record
  estimate.working_state_bytes = scaled(kept_blocks * carry_tile, carry_ratio) + kept_blocks * (kRecordBytes + store::kRecordAlignment) +
                                 quality_bytes + blocks * kRecordBytes;
  estimate.index_bytes += 2 * index_bytes_of(kept_blocks) + index_bytes_of(blocks);
  estimate.file_bytes = estimate.tile_bytes + cost.tiles * kRecordBytes + estimate.working_state_bytes + estimate.index_bytes;

  const bool rate_is_given = megatexels_per_second > 0.0;
  estimate.megatexels_per_second = rate_is_given ? megatexels_per_second : kMegatexelsPerThreadSecond * threads;
  const double base = static_cast<double>(plan.info.data.width) * static_cast<double>(plan.info.data.height);
  estimate.seconds = base / (estimate.megatexels_per_second * 1e6);

  const bool is_raw = plan.compression.codec == store::Codec::kRaw;
  estimate.basis = std::string(is_raw             ? "tiles are stored as they are"
                               : all_are_measured ? "the upper end of what photographs and terrain models gave at zstd:3"
                                                  : "formats that were not measured count as they are before compression") +
                   "; no tile is empty; " +
                   (rate_is_given ? "the rate as given" : "10 million texels a second and thread, measure yours and give it with `rate`");
  return estimate;
}

}  // namespace vt::pipeline
