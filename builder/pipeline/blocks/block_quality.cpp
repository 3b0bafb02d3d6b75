#include "builder/pipeline/blocks/block_quality.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "builder/pipeline/blocks/block_marks.h"
#include "store/io/bytes.h"

namespace vt::pipeline {
namespace {

constexpr std::size_t kSumBytes = 6 * 8;
constexpr std::size_t kLossBytes = 3 * 8;

std::string with_separators(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

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

// The north-western of the four tiles under the block's carry tile; so the root is left for the last block,
// which has no carry.
TileId quality_tile(const Tier& tier, std::int64_t index) {
  if (!tier.has_carry) return {};
  const TileId carry = tier.carry_tile(index);
  return {Level{static_cast<std::uint8_t>(carry.level.value + 1)}, 2 * carry.x, 2 * carry.y};
}

QualityShape quality_shape(const channels::ChannelCodec& codec, std::size_t tier, int levels) {
  return {static_cast<std::size_t>(levels), codec.measures().size(), tier == 0 ? codec.losses().size() : 0};
}

std::size_t block_quality_bytes(const QualityShape& shape) { return shape.levels * shape.measures * kSumBytes + shape.losses * kLossBytes; }

void write_block_quality(const BlockQuality& quality, std::vector<std::byte>& out) {
  out.clear();
  for (const LevelErrors& errors : quality.levels)
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
  for (const channels::LossCount& loss : quality.losses) {
    const std::size_t at = out.size();
    out.resize(at + kLossBytes);
    store::put<std::uint64_t>(out, at, loss.texels);
    store::put<std::uint64_t>(out, at + 8, static_cast<std::uint64_t>(loss.x));
    store::put<std::uint64_t>(out, at + 16, static_cast<std::uint64_t>(loss.y));
  }
}

Result<BlockQuality> read_block_quality(std::span<const std::byte> bytes, const QualityShape& shape) {
  const std::size_t without_losses = block_quality_bytes({shape.levels, shape.measures, 0});
  if (bytes.size() != block_quality_bytes(shape) && bytes.size() != without_losses)
    return fail(ErrorCode::kCorrupt, "a block's quality has " + std::to_string(bytes.size()) + " bytes, " +
                                         std::to_string(block_quality_bytes(shape)) + " are right");
  BlockQuality result{.levels = std::vector<LevelErrors>(shape.levels, LevelErrors(shape.measures)), .losses = LossCounts(shape.losses)};
  std::size_t at = 0;
  for (LevelErrors& errors : result.levels)
    for (channels::ErrorSum& error : errors) {
      error.count = store::get<std::uint64_t>(bytes, at);
      error.sum = store::get_f64(bytes, at + 8);
      error.sum_squares = store::get_f64(bytes, at + 16);
      error.largest = store::get_f64(bytes, at + 24);
      error.reference_total = store::get_f64(bytes, at + 32);
      error.stored_total = store::get_f64(bytes, at + 40);
      at += kSumBytes;
    }
  for (std::size_t i = 0; i < shape.losses && bytes.size() != without_losses; ++i, at += kLossBytes) {
    result.losses[i].texels = store::get<std::uint64_t>(bytes, at);
    result.losses[i].x = static_cast<std::int64_t>(store::get<std::uint64_t>(bytes, at + 8));
    result.losses[i].y = static_cast<std::int64_t>(store::get<std::uint64_t>(bytes, at + 16));
  }
  return result;
}

Result<LayerQuality> collect_quality(const store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work, LayerId layer) {
  const std::size_t measures = plan.codec->measures().size();
  LayerQuality quality{.levels = {}, .losses = LossCounts(plan.codec->losses().size())};
  std::vector<std::byte> bytes;
  for (std::size_t tier_index = 0; tier_index < work.tiers().size(); ++tier_index) {
    const Tier& tier = work.tiers()[tier_index];
    const std::size_t first = quality.levels.size();
    for (int k = 0; k < tier.outputs; ++k)
      quality.levels.push_back({.level = Level{static_cast<std::uint8_t>(tier.base.value - k)}, .errors = LevelErrors(measures)});
    for (const std::int64_t block : work.touched(tier_index)) {
      const TileId tile = quality_tile(tier, block);
      if (!writer.contains(layer, tile)) continue;
      VT_CHECK(writer.read_blob(layer, tile, bytes));
      VT_ASSIGN(const BlockQuality one, read_block_quality(bytes, quality_shape(*plan.codec, tier_index, tier.outputs)));
      for (std::size_t k = 0; k < one.levels.size(); ++k)
        for (std::size_t m = 0; m < measures; ++m) quality.levels[first + k].errors[m] += one.levels[k][m];
      for (std::size_t i = 0; i < one.losses.size(); ++i) quality.losses[i] += one.losses[i];
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
    // A total of next to nothing may be kept any number of times.
    const double kept = error.stored_total / error.reference_total;
    if (error.reference_total != 0.0 && std::isfinite(kept)) row["kept"] = kept;
    entry["levels"].push_back(std::move(row));
  }
  return entry;
}

nlohmann::ordered_json quality_json(const LayerPlan& plan, std::span<const LevelQuality> quality) {
  nlohmann::ordered_json measures = nlohmann::ordered_json::array();
  for (std::size_t m = 0; m < plan.codec->measures().size(); ++m) measures.push_back(measure_json(plan.codec->measures()[m], quality, m));
  return measures;
}

nlohmann::ordered_json losses_json(const LayerPlan& plan, std::span<const channels::LossCount> losses) {
  nlohmann::ordered_json list;
  for (std::size_t i = 0; i < losses.size(); ++i)
    if (losses[i].texels > 0)
      list.push_back({{"texels", losses[i].texels}, {"what", plan.codec->losses()[i].what}, {"first", {losses[i].x, losses[i].y}}});
  return list;
}

std::vector<std::string> loss_remarks(const LayerPlan& plan, std::span<const channels::LossCount> losses) {
  std::vector<std::string> remarks;
  for (std::size_t i = 0; i < losses.size(); ++i)
    if (losses[i].texels > 0)
      remarks.push_back("layer '" + plan.info.name + "': in " + with_separators(losses[i].texels) +
                        (losses[i].texels == 1 ? " texel" : " texels") + " of the finest level (first in " + std::to_string(losses[i].x) +
                        "," + std::to_string(losses[i].y) + ") " + plan.codec->losses()[i].what);
  return remarks;
}

std::vector<std::string> light_remarks(const LayerPlan& plan, std::span<const LevelQuality> levels) {
  constexpr std::uint64_t kFewNumbers = std::uint64_t{1} << 16;
  constexpr double kLittle = 1e-3;
  std::vector<std::string> remarks;
  for (std::size_t m = 0; m < plan.codec->measures().size(); ++m) {
    if (!plan.codec->measures()[m].is_light) continue;
    std::size_t off = 0;
    double worst = 1.0;
    int worst_level = 0;
    for (const LevelQuality& level : levels) {
      const channels::ErrorSum& error = level.errors[m];
      if (error.count < kFewNumbers || !(error.reference_total > 0.0)) continue;
      const double kept = error.stored_total / error.reference_total;
      if (std::abs(kept - 1.0) <= kLittle) continue;
      ++off;
      if (std::abs(kept - 1.0) <= std::abs(worst - 1.0)) continue;
      worst = kept;
      worst_level = level.level.value;
    }
    if (off == 0) continue;
    std::array<char, 32> percent{};
    std::snprintf(percent.data(), percent.size(), "%.2f", 100.0 * worst);
    remarks.push_back("layer '" + plan.info.name + "': " + std::string(format_info(plan.info.format).name) + " keeps " + percent.data() +
                      " % of the light of level " + std::to_string(worst_level) +
                      (off > 1 ? ", the worst of " + std::to_string(off) + " levels" : ", the one level") +
                      " where it is off by more than 0.1 %");
  }
  return remarks;
}

}  // namespace vt::pipeline
