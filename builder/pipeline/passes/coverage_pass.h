// The coarser levels of a mask that is alpha-tested: "inside is what exceeds a reference". Plain means drift
// below the reference where inside is scattered, and a forest thins out with distance. So after all blocks
// are done every level is made again from its plain means (the part "mean", which stays as it is), all
// multiplied by one scale, chosen so that the share of texels above the reference is that of the finest
// level. One scale for a whole level shows no seams. Castaño 2010, "Computing alpha mipmaps".
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "builder/pipeline/blocks/block_job.h"
#include "builder/pipeline/blocks/build_options.h"
#include "builder/pipeline/blocks/built_layer.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// The scale of 16-bit means with which the number of texels whose 8- or 16-bit code (0 to `full`) exceeds
// `reference` comes nearest to `wanted_texels`; 1 when that is no worse. `histogram` has 65536 counts of
// means. Texels of one mean go together, so what is reached may miss by half of the largest count near the
// threshold; `reached_texels` says what it is. Terminates for any histogram; means of 0 stay 0.
struct CoverageScale {
  double scale = 1.0;
  std::uint64_t reached_texels = 0;
};
[[nodiscard]] CoverageScale choose_coverage_scale(std::span<const std::uint64_t> histogram, double wanted_texels, double reference,
                                                  int full);

// Writes the layer's levels above the base from its part "mean", finest first; tiles that are there already
// and equal are left alone, so doing it again after an interruption or an update is right and writes only
// what differs. Adds what was done to `counts`. Returns what was chosen, for the metadata; null for layers
// that have no such levels. The writer may commit meanwhile. kCancelled: all is as before, or partly done.
[[nodiscard]] Result<nlohmann::ordered_json> keep_coverage(store::StoreWriter& writer, const LayerPlan& plan, const BuiltLayer& layer,
                                                           int threads, const std::atomic<bool>* cancel, TileCounts& counts);

}  // namespace vt::pipeline
