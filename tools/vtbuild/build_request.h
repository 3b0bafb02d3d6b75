// Building what is asked for: one layer, or all layers of a scene. What `vtbuild layer`, `dataset` and
// `update` share. One thread.
#pragma once

#include <filesystem>

#include "builder/pipeline/request/layer_request.h"
#include "store/result.h"
#include "tools/vtbuild/build_flags.h"

namespace vt::tools {

// The layer is built as it was asked for, with paths relative to `folder`, and remembers that (recipe.h). The
// value is the exit code.
[[nodiscard]] Result<int> build_asked(const pipeline::LayerRequest& asked, const std::filesystem::path& folder,
                                      const std::filesystem::path& store, const BuildFlags& flags);

// Likewise every layer of the scene file, as it is now.
[[nodiscard]] Result<int> build_scene(const std::filesystem::path& scene, const std::filesystem::path& folder,
                                      const std::filesystem::path& store, const BuildFlags& flags);

}  // namespace vt::tools
