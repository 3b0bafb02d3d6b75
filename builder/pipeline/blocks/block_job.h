// One block of one tier from its samples to finished tiles: the unit of parallel work, of resuming and of
// updating. A job touches nothing but its own buffers and the store, and needs no other block of its tier; it
// could as well run on another machine. One object per worker thread, reused for many blocks.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "builder/pipeline/blocks/block_marks.h"
#include "builder/pipeline/blocks/build_stats.h"
#include "builder/pipeline/blocks/put_tile.h"
#include "builder/pipeline/blocks/tile_output.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pipeline/plan/work_map.h"
#include "builder/pipeline/plan/wrapped_chunk.h"
#include "builder/pyramid/cascade.h"
#include "builder/resample/base_sampler.h"
#include "store/store_writer.h"

namespace vt::pipeline {

class BlockJob {
 public:
  // All arguments outlive the job. `timed`: keep times().
  BlockJob(const LayerPlan& plan, const WorkMap& work, const LayerIds& ids, store::StoreWriter& writer, bool timed);

  // Builds block `index` of a tier; blocks of tier 0 read the sources, others the carry tiles of the tier
  // before. The block's mark comes last: when it is there, all of the block is. Calls `progress` with the
  // number of core base texels done since the last call. kCancelled as soon as `cancel` is seen; then nothing
  // of the block counts.
  [[nodiscard]] Result<void> run(std::size_t tier, std::int64_t index, const std::function<void(std::uint64_t)>& progress,
                                 const std::atomic<bool>* cancel);
  // The mark that run() would leave for a block of tier 0, without decoding anything.
  [[nodiscard]] Result<store::ContentHash> source_hash(std::int64_t index);

  [[nodiscard]] const TileCounts& counts() const { return counts_; }
  [[nodiscard]] StageClock& clock() { return clock_; }

 private:
  void start_content();
  [[nodiscard]] Result<void> put_blob(LayerId layer, TileId tile, std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> feed_from_sources(pyramid::Cascade& cascade, TileOutput& output,
                                               const std::function<void(std::uint64_t)>& progress, const std::atomic<bool>* cancel);
  [[nodiscard]] Result<void> feed_from_carry(std::size_t tier, pyramid::Cascade& cascade, TileOutput& output,
                                             const std::atomic<bool>* cancel);
  [[nodiscard]] Result<void> load_carry_band(std::size_t tier, std::int64_t tile_row);

  const LayerPlan& plan_;
  const WorkMap& work_;
  const LayerIds& ids_;
  store::StoreWriter& writer_;
  BlockMarks marks_;
  store::ContentHasher content_;
  StageClock clock_;
  TileCounts counts_;
  WrappedChunk chunk_;
  std::vector<std::int64_t> carry_columns_;         // of tiles
  std::vector<std::vector<std::byte>> carry_band_;  // tiles of one row
  std::vector<std::byte> blob_;
  std::vector<std::byte> compressed_;
};

}  // namespace vt::pipeline
