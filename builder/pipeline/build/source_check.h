// What an update does before it builds: finds the blocks whose sources are not what they were built from, and
// marks them, and every block above that depends on them, stale.
#pragma once

#include <cstdint>
#include <vector>

#include "builder/pipeline/blocks/build_options.h"
#include "builder/pipeline/blocks/built_layer.h"
#include "builder/pipeline/plan/work_map.h"

namespace vt::pipeline {

struct SourceCheck {
  std::int64_t checked = 0;
  std::vector<std::int64_t> changed;  // blocks of tier 0, ascending
  StageTimes stages;
};

// Reads all sources once, decodes nothing.
[[nodiscard]] Result<SourceCheck> check_sources(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work,
                                                const BuiltLayer& layer, int threads, const BuildOptions& options);

// `changed` are blocks of tier 0. Does not commit.
[[nodiscard]] Result<void> mark_stale(store::StoreWriter& writer, const WorkMap& work, const BuiltLayer& layer,
                                      std::vector<std::int64_t> changed);

// Blocks of a tier that are to be built, ascending, and the work that is done already, in texels of the
// tier's base.
struct Pending {
  std::vector<std::int64_t> blocks;
  std::uint64_t texels = 0;
  std::uint64_t done_texels = 0;
  std::int64_t done_blocks = 0;
};
[[nodiscard]] Result<Pending> find_pending(store::StoreWriter& writer, const WorkMap& work, const BuiltLayer& layer, std::size_t tier);

}  // namespace vt::pipeline
