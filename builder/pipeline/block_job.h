// One block of one tier from its samples to finished tiles: the unit of parallel work, of resuming and of updating. A job touches nothing
// but its own buffers and the store, and needs no other block of its tier; it could as well run on another machine. One object per worker
// thread, reused for many blocks.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "builder/encode/tile_band.h"
#include "builder/pipeline/layer_plan.h"
#include "builder/pyramid/block_cascade.h"
#include "builder/resample/base_sampler.h"
#include "store/store_writer.h"

namespace vt::pipeline {

struct LayerIds {
  LayerId texture;
  LayerId carry;  // meaningful when a tier has carry
};

class BlockJob {
 public:
  BlockJob(const LayerPlan& plan, LayerIds ids, store::StoreWriter& writer);

  // Builds block `index` of `tier`; `first_tier` blocks read the sources, others the carry tiles of the tier before. Calls `progress` with
  // the number of core base texels done since the last call. kCancelled as soon as `cancel` is seen; then nothing of the block counts.
  [[nodiscard]] Result<void> run(const Tier& tier, bool first_tier, std::int64_t index, const std::function<void(std::uint64_t)>& progress,
                                 const std::atomic<bool>* cancel);

 private:
  class Output;
  [[nodiscard]] Result<void> put(LayerId layer, const encode::EncodedTile& tile);
  [[nodiscard]] Result<void> feed_from_sources(pyramid::BlockCascade& cascade, Output& output,
                                               const std::function<void(std::uint64_t)>& progress, const std::atomic<bool>* cancel);
  [[nodiscard]] Result<void> feed_from_carry(const Tier& tier, pyramid::BlockCascade& cascade, Output& output);
  [[nodiscard]] Result<void> load_carry_band(const Tier& tier, std::int64_t tile_row, const TexelRect& active);

  const LayerPlan& plan_;
  LayerIds ids_;
  store::StoreWriter& writer_;
  resample::BaseChunk chunk_;
  std::vector<std::vector<float>> carry_band_;  // tiles of one row, interleaved planes
};

}  // namespace vt::pipeline
