// Carries out a plan: blocks on all cores, tiles into the store, checkpoints on the way. A build that was
// interrupted goes on where its last checkpoint left it when the same plan is built again; the tiles are the
// same bytes at any thread count, block size or number of interruptions.
//
// Updating is the same work with a question before it: blocks whose sources are not what they were built from
// are marked stale, and what depends on them; then the build goes on as after an interruption.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/pipeline/blocks/block_job.h"
#include "builder/pipeline/blocks/build_options.h"
#include "builder/pipeline/blocks/build_stats.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "store/store_writer.h"

namespace vt::pipeline {

struct BuildReport {
  bool was_complete = false;  // nothing to do
  std::int64_t blocks_built = 0;
  std::int64_t blocks_resumed = 0;   // found in the store from an earlier run
  std::int64_t blocks_checked = 0;   // whose sources were compared
  std::int64_t blocks_changed = 0;   // of them
  TileCounts tile_counts;            // of this run
  std::vector<std::string> remarks;  // what became of the data that whoever builds the layer should know, in sentences
  std::uint64_t base_texels = 0;     // of the data at the finest level
  std::uint64_t tiles = 0;
  std::uint64_t constant_tiles = 0;
  std::uint64_t stored_bytes = 0;
  int block_levels = 0;
  int threads = 0;
  double seconds = 0.0;
  double commit_seconds = 0.0;  // while checkpoints were written; workers go on beside them
  StageTimes stages;            // when asked for
};

// The writer is used by this call alone until it returns, and is left committed: with the layer complete, or
// with all blocks that were done before an error. A layer of that name that was never finished gives way, or
// is gone on with, as open_built_layer() says. kExists: the store has a layer of that name built from other
// settings. kIo: the store stays at its last checkpoint.
[[nodiscard]] Result<BuildReport> build_layer(store::StoreWriter& writer, const LayerPlan& plan, const BuildOptions& options);

// Whether a build that failed will fail again: the same command on the same data would end in the same way.
[[nodiscard]] bool is_of_the_data(ErrorCode code);

}  // namespace vt::pipeline
