// Which tiles texture a piece of geometry, given its bounding box in (s, t) and what the tile textures show
// right now. Fixed-function path: the finest tile that covers the box alone. Shader path: tiles finest first
// that cover it together. Pure functions over values that residency.h keeps; no allocation.
#pragma once

#include <span>

#include "runtime/paging.h"

namespace vt::runtime {

struct SelectableTile {
  Box box;             // what the texture shows
  bool shown = false;  // false: nothing was loaded yet
  int slot = -1;       // residency's name for it
};

struct SelectableLevel {
  Box box;  // the union of the boxes of the tiles that show something
  bool any_shown = false;
  double tolerance = 0.0;  // how far outside its tile a box may reach and still count as covered: a thousandth of a texel, far below the
                           // filter's own precision
  std::span<const SelectableTile> tiles;
};

// The finest tile that covers `box` alone; else the coarsest level's tile with covers = false; count 0 while
// nothing at all is loaded.
[[nodiscard]] StageSet select_one(std::span<const SelectableLevel> finest_first, const Box& box);

// At most `cap` tiles (1..kMaxStages), finest first. When the finer tiles cannot cover the box within the
// cap, the last stage is the tile that select_one() gives, so the set covers whenever that tile does. Tiles
// that finer ones hide completely are left out.
[[nodiscard]] StageSet select_stages(std::span<const SelectableLevel> finest_first, const Box& box, int cap);

}  // namespace vt::runtime
