// Where the texels of a layer's grid fall in a source raster. Exact (through the projections) on a lattice fixed to the layer's grid,
// bilinear between, and exact everywhere in lattice cells whose centre would be off by more than kTolerance: so the answer does not depend
// on how work is cut into blocks. Immutable; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "builder/geo/crs.h"
#include "builder/geo/geo_transform.h"
#include "store/layer.h"
#include "store/vt_mapping.h"

namespace vt::resample {

class GridWarp {
 public:
  static constexpr double kTolerance = 1.0 / 1024.0;  // source samples
  static constexpr std::int64_t kCell = 32;           // texels from one lattice node to the next

  // From texels of the grid (continuous, column 0 at the west edge of the data rectangle) to the source's columns and rows. `turns`: the
  // source is meant so many times round the globe to the east of where it says it lies.
  GridWarp(const GridPlacement& grid, geo::Crs grid_crs, const geo::GeoTransform& source, geo::Crs source_crs, int turns = 0);

  // NaN where the projections have no answer.
  [[nodiscard]] Point2 exact(Point2 texel) const;
  // Source positions of the centres of all texels of `rect`, row by row, tightly packed.
  void map_centres(const TexelRect& rect, std::span<Point2> out) const;
  // Everything that decides the answers, as text: two warps with the same facts give the same positions.
  [[nodiscard]] const std::string& facts() const { return facts_; }

 private:
  void map_cell(std::int64_t cell_x, std::int64_t cell_y, const TexelRect& part, const TexelRect& rect, std::span<Point2> out) const;

  GridPlacement grid_;
  geo::Crs grid_crs_;
  geo::GeoTransform raster_from_source_crs_;
  geo::Crs source_crs_;
  bool same_crs_;
  double moved_;  // by `turns`, to the east: units of the grid if both systems are the same, else degrees
  std::string facts_;
};

}  // namespace vt::resample
