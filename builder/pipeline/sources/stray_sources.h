// Files that do not seem to belong to a mosaic: one that lies far from all others or counts in another unit
// makes a layer that is empty but for a few texels, or too large for any store. Arithmetic only; any thread.
#pragma once

#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/pipeline/sources/layer_grid.h"
#include "builder/pipeline/sources/open_sources.h"

namespace vt::pipeline {

class Strays {
 public:
  void add(std::string text) { texts_.push_back(std::move(text)); }
  [[nodiscard]] bool empty() const { return texts_.empty(); }
  // To be added to an error that they may be the reason of; "" without any.
  [[nodiscard]] std::string as_reason() const;
  void append_to(std::vector<std::string>& warnings) const;

 private:
  std::vector<std::string> texts_;  // in the order of the sources
};

// `bounds` of the sources in the layer's CRS, one by one. A source strays when its centre is more than a
// hundred times as far from the others' as they are large or scattered, or its samples are a thousand times
// as large or as small; medians say what the others are. Of two sources the second one is told.
[[nodiscard]] Strays find_strays(const geo::Crs& crs, const std::vector<OpenSource>& sources, const std::vector<Bounds>& bounds);

}  // namespace vt::pipeline
