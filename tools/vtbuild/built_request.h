// What a layer was asked for as, found out from the store alone: the request of its builder, with a raster of the caller's in place of the
// sources. For programs that hold rasters beside a layer that was built. One thread; changes the current folder while it runs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "builder/pipeline/plan/layer_plan.h"
#include "builder/pipeline/request/layer_request.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/store_reader.h"

namespace vt::tools {

// From the layer's recipe, the command that built it; where there is none, from its settings. `layer` is no part and no carry; `raster` is
// read as that command read its sources (of a scene, the one of the same name, or the first). Fails with the reason when it cannot be
// known: a scene or a table that is not where it was.
[[nodiscard]] Result<pipeline::LayerRequest> built_request(const store::StoreReader& reader, const LayerInfo& layer,
                                                           const pipeline::DatasetFrame& frame, const std::filesystem::path& raster);

// Of `vtbuild layer`: what its arguments ask for, of this raster instead of its inputs.
[[nodiscard]] Result<pipeline::LayerRequest> layer_request_of(std::vector<std::string> arguments, const std::filesystem::path& raster,
                                                              const pipeline::DatasetFrame& frame);

}  // namespace vt::tools
