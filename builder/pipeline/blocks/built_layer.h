// A layer under construction as the store keeps it: the texture, the carry between tiers, the marks of
// finished blocks, and the metadata that let a later run go on.
#pragma once

#include <nlohmann/json.hpp>

#include "builder/pipeline/blocks/block_job.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "store/store_writer.h"

namespace vt::pipeline {

struct BuiltLayer {
  LayerIds ids;
  int block_levels = 0;
  bool was_there = false;
  bool is_complete = false;
  bool was_complete = false;    // at some time; until then nobody can rely on it
  bool sources_differ = false;  // the layer was built from another list of sources, or from files that have changed since
  // Stale marks may lie where no source reaches any more.
  bool is_updating = false;
  std::string remark;  // for the user, when the layer that was there is not what the plan goes on with; else empty
};

// Finds the layer of `plan`, or adds it and commits. A layer of that name that was never finished gives way
// to other settings when nothing of it is built, or when its own build failed for its data; with other
// sources the plan goes on with it, as an update. Otherwise kExists: the layer has other settings, or other
// sources without `may_differ_in_sources`. kInvalidData: the layer cannot go on, because its working state is
// not in the store.
[[nodiscard]] Result<BuiltLayer> open_built_layer(store::StoreWriter& writer, const LayerPlan& plan, int block_levels,
                                                  bool may_differ_in_sources);

// The layer is unfinished from here on, and its sources are those of `plan`. Does not commit.
[[nodiscard]] Result<void> begin_update(store::StoreWriter& writer, const LayerPlan& plan, BuiltLayer& layer);
// Notes in a layer that was never complete whether its build has failed for its data, so that it can only be
// built with another command or other data. Does not commit.
[[nodiscard]] Result<void> note_failure(store::StoreWriter& writer, const BuiltLayer& layer, bool has_failed);
// Whether the store holds anything that a build has come to: a complete layer, or a block of an unfinished
// one.
[[nodiscard]] Result<bool> holds_built_work(const store::StoreWriter& writer);

// What passes after the blocks found out, for the metadata.
struct PassFindings {
  nlohmann::ordered_json alpha_coverage;  // of keep_coverage(); null: none
  nlohmann::ordered_json surface;         // a measure like those of quality_json(); null: none
};

// All blocks and passes are done: adds up what was measured of them. Commits. Returns what whoever builds the
// layer should know of it.
[[nodiscard]] Result<std::vector<std::string>> complete(store::StoreWriter& writer, const LayerPlan& plan, const WorkMap& work,
                                                        const BuiltLayer& layer, const PassFindings& findings);

}  // namespace vt::pipeline
