// Which kernels a channel's levels may be made with, and how its sources may be resampled.
#pragma once

#include "builder/pipeline/request/layer_request.h"
#include "builder/pyramid/halving_kernel.h"
#include "store/result.h"

namespace vt::pipeline {

// The kernel that is asked for, or the channel's own. kUsage: it does not exist, or it would be wrong for
// what the numbers mean; the message says why.
[[nodiscard]] Result<pyramid::HalvingKernel> choose_kernel(const LayerRequest& request);
// Likewise for sources on another grid.
[[nodiscard]] Result<resample::Method> choose_resampling(const LayerRequest& request);

}  // namespace vt::pipeline
