// What a layer was asked for as, found out from the store alone: the request of its builder, with a raster of
// the caller's in place of the sources. For programs that hold rasters beside a layer that was built. Any
// thread.
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

// From the layer's recipe (recipe.h); where there is none, from its settings. `layer` is no part and no
// carry; `raster` is read as the source of the same name was, or the first. Fails with the reason when it
// cannot be known: a scene or a table that is not where it was.
[[nodiscard]] Result<pipeline::LayerRequest> built_request(const store::StoreReader& reader, const LayerInfo& layer,
                                                           const pipeline::DatasetFrame& frame, const std::filesystem::path& raster);

}  // namespace vt::tools
