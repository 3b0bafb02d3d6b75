// How far a layer's texels lie from what they should be, level by level, and what those of the finest level
// cannot say: measured block by block while tiles are encoded, kept in the layer `NAME/quality` (one blob a
// block) so that stopped and updated builds know all of it, and added up in the order of the blocks, so that
// the sums do not depend on threads.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "builder/channels/codec/error_sum.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pipeline/plan/work_map.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// One sum for each measure of the layer's codec.
using LevelErrors = std::vector<channels::ErrorSum>;

struct LevelQuality {
  Level level;
  LevelErrors errors;
};

// One count for each of the codec's losses.
using LossCounts = std::vector<channels::LossCount>;

struct BlockQuality {
  std::vector<LevelErrors> levels;  // [k] belongs to the block's level k, 0 = its base
  LossCounts losses;                // of its base, when that is the layer's finest level; otherwise empty
};

struct LayerQuality {
  std::vector<LevelQuality> levels;  // finest first
  LossCounts losses;
};

// The layer that holds the measurements of `plan`, one level finer than its marks; its owner is for the
// caller to fill in.
[[nodiscard]] LayerInfo describe_quality(const LayerPlan& plan, int block_levels);
// Where in it a block is.
[[nodiscard]] TileId quality_tile(const Tier& tier, std::int64_t index);

// What a block's blob holds of a layer.
struct QualityShape {
  std::size_t levels = 0;
  std::size_t measures = 0;
  std::size_t losses = 0;
};
// `tier` counts from 0, whose base is the layer's finest level.
[[nodiscard]] QualityShape quality_shape(const channels::ChannelCodec& codec, std::size_t tier, int levels);
[[nodiscard]] std::size_t block_quality_bytes(const QualityShape& shape);
// Little-endian, no compression.
void write_block_quality(const BlockQuality& quality, std::vector<std::byte>& out);
// kCorrupt: not the bytes of such a block. Blobs that were written before losses were counted have none of
// them.
[[nodiscard]] Result<BlockQuality> read_block_quality(std::span<const std::byte> bytes, const QualityShape& shape);

// Over all blocks that are there. Memory does not depend on their number.
[[nodiscard]] Result<LayerQuality> collect_quality(const store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work,
                                                   LayerId layer);

// One measure of every level that has it, `index` among the errors of a level.
[[nodiscard]] nlohmann::ordered_json measure_json(const channels::Measure& measure, std::span<const LevelQuality> quality,
                                                  std::size_t index);
// All of them, for the layer's metadata, which schemas/store-metadata.schema.json describes.
[[nodiscard]] nlohmann::ordered_json quality_json(const LayerPlan& plan, std::span<const LevelQuality> quality);
// Likewise the losses that occurred; null: none did.
[[nodiscard]] nlohmann::ordered_json losses_json(const LayerPlan& plan, std::span<const channels::LossCount> losses);
// The same in sentences, for whoever builds the layer.
[[nodiscard]] std::vector<std::string> loss_remarks(const LayerPlan& plan, std::span<const channels::LossCount> losses);
// Likewise, where the format does not keep the light of a level to 0.1 %: of the level that is worst. Levels
// of fewer than 2^16 numbers may be off by chance and are passed over.
[[nodiscard]] std::vector<std::string> light_remarks(const LayerPlan& plan, std::span<const LevelQuality> levels);

}  // namespace vt::pipeline
