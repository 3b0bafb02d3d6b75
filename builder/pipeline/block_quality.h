// How far a layer's texels lie from what they should be, level by level: measured block by block while tiles are encoded, kept in the layer
// `NAME/quality` (one blob a block) so that stopped and updated builds know all of it, and added up in the order of the blocks, so that the
// sums do not depend on threads.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "builder/channels/error_sum.h"
#include "builder/pipeline/layer_plan.h"
#include "builder/pipeline/work_map.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// One sum for each measure of the layer's codec.
using LevelErrors = std::vector<channels::ErrorSum>;

struct LevelQuality {
  Level level;
  LevelErrors errors;
};

// The layer that holds the measurements of `plan`, one level finer than its marks; its owner is for the caller to fill in.
[[nodiscard]] LayerInfo describe_quality(const LayerPlan& plan, int block_levels);
// Where in it a block is.
[[nodiscard]] TileId quality_tile(const Tier& tier, std::int64_t index);

// Of one block with so many levels.
[[nodiscard]] std::size_t block_quality_bytes(std::size_t levels, std::size_t measures);
// `levels[k]` belongs to the block's level k, 0 = its base. Little-endian, no compression.
void write_block_quality(std::span<const LevelErrors> levels, std::vector<std::byte>& out);
// kCorrupt: not the bytes of `levels` levels of `measures` measures.
[[nodiscard]] Result<std::vector<LevelErrors>> read_block_quality(std::span<const std::byte> bytes, std::size_t levels,
                                                                  std::size_t measures);

// Over all blocks that are there; finest level first. Memory does not depend on their number.
[[nodiscard]] Result<std::vector<LevelQuality>> collect_quality(const store::StoreWriter& writer, const LayerPlan& plan,
                                                                const WorkMap& work, LayerId layer);

// One measure of every level that has it, `index` among the errors of a level.
[[nodiscard]] nlohmann::ordered_json measure_json(const channels::Measure& measure, std::span<const LevelQuality> quality,
                                                  std::size_t index);
// All of them, for the layer's metadata, which schemas/store-metadata.schema.json describes.
[[nodiscard]] nlohmann::ordered_json quality_json(const LayerPlan& plan, std::span<const LevelQuality> quality);

}  // namespace vt::pipeline
