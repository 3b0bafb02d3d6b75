#include "builder/pipeline/plan/build_state.h"

#include "builder/text/json_text.h"

namespace vt::pipeline {

BuildState state_of(const LayerInfo& layer) {
  BuildState state;
  const auto metadata = text::json_or_null(layer.metadata_json);
  state.is_ours = metadata.is_object() && metadata.contains("settings") && metadata["settings"].is_object() &&
                  metadata.contains("block_levels") && metadata["block_levels"].is_number_integer();
  if (!state.is_ours) return state;
  state.settings = metadata["settings"];
  state.block_levels = metadata["block_levels"].get<int>();
  state.is_updating = metadata.contains(kUpdating);
  state.was_complete = layer.state == LayerState::kComplete || (state.is_updating && metadata[kUpdating] != false);
  state.has_failed = metadata.contains(kFailed);
  return state;
}

bool was_ever_complete(const LayerInfo& layer) { return state_of(layer).was_complete; }

}  // namespace vt::pipeline
