// How far the surface through a coarser level's heights lies from the finest level: what a program that draws
// terrain needs to choose its level. Measured exactly, after all blocks are done, over every height that is
// stored.
#pragma once

#include <atomic>
#include <vector>

#include "builder/pipeline/blocks/block_quality.h"
#include "builder/pipeline/blocks/built_layer.h"
#include "builder/pipeline/plan/layer_plan.h"
#include "store/store_writer.h"

namespace vt::pipeline {

// What each thread of measure_surface() holds at most: a few decoded tiles of every level. 0 for layers that
// do not ask for it.
[[nodiscard]] std::size_t surface_thread_bytes(const LayerPlan& plan);

// For every level but the finest, finer ones first: | z - s | over the texels of the finest level, where s is
// the bilinear surface through the level's heights, in metres. Heights of means lie at the centres of their
// texels, those of the kernel "point" at the north-western corner's texel; beyond the outermost ones the
// surface goes on level. Where one of the four heights of s is void, or z is, nothing is measured. All sums
// are taken in the order of the tiles. Empty for layers that do not ask for it. Each finest tile is read
// once, coarser ones about as often as they have rows of finest tiles under them. kCancelled as soon as
// `cancel` is seen.
[[nodiscard]] Result<std::vector<LevelQuality>> measure_surface(const store::StoreWriter& writer, const LayerPlan& plan,
                                                                const BuiltLayer& layer, int threads, const std::atomic<bool>* cancel);

}  // namespace vt::pipeline
