#include "builder/pipeline/plan_cost.h"

#include <cmath>

#include "store/layout.h"

namespace vt::pipeline {
namespace {

// Stored to raw bytes at zstd:3, the upper end of what aerial and satellite photographs and terrain models gave: photographs 0.2 to 0.4
// (coverage costs nothing), their BC1 blocks 0.4 to 0.7, heights 0.15 to 0.45. Carry is stored at zstd:1.
constexpr double kPhotographRatio = 0.40;
constexpr double kPhotographWithCoverageRatio = 0.30;
constexpr double kBlockRatio = 0.70;
constexpr double kHeightRatio = 0.45;
constexpr double kColorCarryRatio = 0.55;
constexpr double kHeightCarryRatio = 0.25;

double tile_ratio(const LayerPlan& plan) {
  if (plan.compression.codec == store::Codec::kRaw) return 1.0;
  switch (plan.info.format) {
    case TexelFormat::kRgb8:
      return kPhotographRatio;
    case TexelFormat::kRgba8:
      return kPhotographWithCoverageRatio;
    case TexelFormat::kBc1:
      return kBlockRatio;
    default:
      return kHeightRatio;
  }
}

std::uint64_t scaled(std::uint64_t bytes, double ratio) {
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(bytes) * ratio));
}

// Entries and the heads of their pages, one page for 1024 tiles side by side, and about a thirtieth for the pages above.
std::uint64_t index_bytes_of(std::uint64_t entries) {
  const std::uint64_t pages = entries / store::kPageSlots + 1;
  return entries * store::kReferenceBytes + pages * (store::kPageEntriesAt + store::kRecordHeaderBytes) * 31 / 30;
}

}  // namespace

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

PlanCost plan_cost(const LayerPlan& plan) {
  PlanCost cost = plan_cost(plan.parts.front());
  for (std::size_t i = 1; i < plan.parts.size(); ++i) {
    const PlanCost part = plan_cost(plan.parts[i]);
    cost.tiles += part.tiles;
    cost.raw_bytes += part.raw_bytes;
  }
  return cost;
}

PlanEstimate estimate_cost(const LayerPlan& plan, int block_levels, int threads, double megatexels_per_second) {
  const PlanCost cost = plan_cost(plan);
  PlanEstimate estimate;
  estimate.tile_ratio = tile_ratio(plan);
  estimate.tile_bytes = scaled(cost.raw_bytes, estimate.tile_ratio);

  // Every block but the last leaves one tile of carry and one mark.
  std::uint64_t kept_blocks = 0;
  for (const Tier& tier : plan_tiers(plan.info, block_levels))
    if (tier.has_carry) kept_blocks += static_cast<std::uint64_t>(tier.blocks());
  const std::uint64_t carry_tile =
      std::uint64_t{plan.info.tile_texels()} * plan.info.tile_texels() * static_cast<std::uint64_t>(plan.codec->planes()) * sizeof(float);
  const double carry_ratio = plan.info.channel == ChannelType::kElevation ? kHeightCarryRatio : kColorCarryRatio;
  constexpr std::uint64_t kRecordBytes = store::kRecordHeaderBytes + store::kRecordAlignment / 2;  // header, and up to the next record
  estimate.working_state_bytes = scaled(kept_blocks * carry_tile, carry_ratio) + kept_blocks * (kRecordBytes + store::kRecordAlignment);
  estimate.index_bytes = index_bytes_of(cost.tiles) + 2 * index_bytes_of(kept_blocks);
  estimate.file_bytes = estimate.tile_bytes + cost.tiles * kRecordBytes + estimate.working_state_bytes + estimate.index_bytes;

  const bool rate_is_given = megatexels_per_second > 0.0;
  estimate.megatexels_per_second = rate_is_given ? megatexels_per_second : kMegatexelsPerThreadSecond * threads;
  const double base = static_cast<double>(plan.info.data.width) * static_cast<double>(plan.info.data.height);
  estimate.seconds = base / (estimate.megatexels_per_second * 1e6);

  const bool is_raw = plan.compression.codec == store::Codec::kRaw;
  estimate.basis =
      std::string(is_raw ? "tiles are stored as they are" : "the upper end of what photographs and terrain models gave at zstd:3") +
      "; no tile is empty; " +
      (rate_is_given ? "the rate as given" : "10 million texels a second and thread, measure yours and give it with --rate");
  return estimate;
}

}  // namespace vt::pipeline
