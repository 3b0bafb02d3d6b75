// Sources of one grid, at their place among the grids of a layer. Private to this folder. Immutable once
// made; any thread.
#pragma once

#include <memory>

#include "builder/resample/grid/grid_warp.h"
#include "builder/resample/grid/placed_source.h"
#include "builder/resample/grid/sample_grid.h"

namespace vt::resample {

struct GridSources {
  SampleGrid grid;
  std::shared_ptr<const GridWarp> warp;  // null: the grid is the layer's own
  Method method = Method::kBilinear;
  bool counts_areas = false;  // they are classes, and some texels lie over many samples

  [[nodiscard]] const channels::ChannelCodec& codec() const { return *grid.members().front().source->codec; }
  // Values of a surface stay in their place, unless samples are to stay as they are.
  [[nodiscard]] bool is_surface() const { return codec().is_surface() && method == Method::kBilinear; }
};

}  // namespace vt::resample
