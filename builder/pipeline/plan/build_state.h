// What the metadata of a stored layer say of the builds that it has gone through. Pure functions, any thread.
#pragma once

#include <nlohmann/json.hpp>

#include "store/layer.h"

namespace vt::pipeline {

// Between the checkpoints of an update: whether the layer was complete before. Older programs wrote nothing
// but true.
inline constexpr const char* kUpdating = "updating";
// The build cannot come to its end with these data.
inline constexpr const char* kFailed = "failed";

struct BuildState {
  bool is_ours = false;
  bool was_complete = false;
  bool is_updating = false;
  bool has_failed = false;
  nlohmann::ordered_json settings;
  int block_levels = 0;
};

[[nodiscard]] BuildState state_of(const LayerInfo& layer);
// Whether the layer is complete, or was before an update of it was stopped.
[[nodiscard]] bool was_ever_complete(const LayerInfo& layer);

}  // namespace vt::pipeline
