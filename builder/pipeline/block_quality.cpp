#include "builder/pipeline/block_quality.h"

#include <nlohmann/json.hpp>
#include <string>

#include "builder/pipeline/block_marks.h"
#include "store/bytes.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kSumBytes = 6 * 8;

}  // namespace

LayerInfo describe_quality(const LayerPlan& plan, int block_levels) {
  LayerInfo info = BlockMarks::describe(plan, block_levels);
  info.name = plan.info.name + "/quality";
  info.format = TexelFormat::kBlob;
  if (!plan_tiers(plan.info, block_levels).front().has_carry) return info;
  info.finest = Level{static_cast<std::uint8_t>(info.finest.value + 1)};
  info.data = finer(info.data, 1);
  info.grid.step_x /= 2.0;
  info.grid.step_y /= 2.0;
  return info;
}

// The north-western of the four tiles under the block's carry tile; so the root is left for the last block, which has no carry.
TileId quality_tile(const Tier& tier, std::int64_t index) {
  if (!tier.has_carry) return {};
  const TileId carry = tier.carry_tile(index);
  return {Level{static_cast<std::uint8_t>(carry.level.value + 1)}, 2 * carry.x, 2 * carry.y};
}

std::size_t block_quality_bytes(std::size_t levels, std::size_t measures) { return levels * measures * kSumBytes; }

void write_block_quality(std::span<const LevelErrors> levels, std::vector<std::byte>& out) {
  out.clear();
  for (const LevelErrors& errors : levels)
    for (const channels::ErrorSum& error : errors) {
      const std::size_t at = out.size();
      out.resize(at + kSumBytes);
      store::put<std::uint64_t>(out, at, error.count);
      store::put_f64(out, at + 8, error.sum);
      store::put_f64(out, at + 16, error.sum_squares);
      store::put_f64(out, at + 24, error.largest);
      store::put_f64(out, at + 32, error.reference_total);
      store::put_f64(out, at + 40, error.stored_total);
    }
}

Result<std::vector<LevelErrors>> read_block_quality(std::span<const std::byte> bytes, std::size_t levels, std::size_t measures) {
  if (bytes.size() != block_quality_bytes(levels, measures))
    return fail(ErrorCode::kCorrupt, "a block's quality has " + std::to_string(bytes.size()) + " bytes, " +
                                         std::to_string(block_quality_bytes(levels, measures)) + " are right");
  std::vector<LevelErrors> result(levels, LevelErrors(measures));
  std::size_t at = 0;
  for (LevelErrors& errors : result)
    for (channels::ErrorSum& error : errors) {
      error.count = store::get<std::uint64_t>(bytes, at);
      error.sum = store::get_f64(bytes, at + 8);
      error.sum_squares = store::get_f64(bytes, at + 16);
      error.largest = store::get_f64(bytes, at + 24);
      error.reference_total = store::get_f64(bytes, at + 32);
      error.stored_total = store::get_f64(bytes, at + 40);
      at += kSumBytes;
    }
  return result;
}

Result<std::vector<LevelQuality>> collect_quality(const store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work,
                                                  LayerId layer) {
  const std::size_t measures = plan.codec->measures().size();
  std::vector<LevelQuality> quality;
  std::vector<std::byte> bytes;
  for (std::size_t tier_index = 0; tier_index < work.tiers().size(); ++tier_index) {
    const Tier& tier = work.tiers()[tier_index];
    const std::size_t first = quality.size();
    for (int k = 0; k < tier.outputs; ++k)
      quality.push_back({.level = Level{static_cast<std::uint8_t>(tier.base.value - k)}, .errors = LevelErrors(measures)});
    for (const std::int64_t block : work.touched(tier_index)) {
      const TileId tile = quality_tile(tier, block);
      if (!writer.contains(layer, tile)) continue;
      VT_CHECK(writer.read_blob(layer, tile, bytes));
      VT_ASSIGN(const std::vector<LevelErrors> levels, read_block_quality(bytes, static_cast<std::size_t>(tier.outputs), measures));
      for (std::size_t k = 0; k < levels.size(); ++k)
        for (std::size_t m = 0; m < measures; ++m) quality[first + k].errors[m] += levels[k][m];
    }
  }
  return quality;
}

nlohmann::ordered_json measure_json(const channels::Measure& measure, std::span<const LevelQuality> quality, std::size_t index) {
  nlohmann::ordered_json entry;
  entry["name"] = measure.name;
  if (!measure.unit.empty()) entry["unit"] = measure.unit;
  for (const LevelQuality& level : quality) {
    const channels::ErrorSum& error = level.errors[index];
    if (error.count == 0) continue;
    nlohmann::ordered_json row;
    row["level"] = level.level.value;
    row["measured"] = error.count;
    row["mean"] = error.mean();
    row["rms"] = error.root_mean_square();
    row["max"] = error.largest;
    if (error.reference_total != 0.0) row["kept"] = error.stored_total / error.reference_total;
    entry["levels"].push_back(std::move(row));
  }
  return entry;
}

nlohmann::ordered_json quality_json(const LayerPlan& plan, std::span<const LevelQuality> quality) {
  nlohmann::ordered_json measures = nlohmann::ordered_json::array();
  for (std::size_t m = 0; m < plan.codec->measures().size(); ++m) measures.push_back(measure_json(plan.codec->measures()[m], quality, m));
  return measures;
}

}  // namespace vt::pipeline
