// The one place that turns database texture coordinates (u, v) into texels and back, in double throughout.
//
// Three spaces:
//   (u, v)   0..1 over the dataset's area, (0, 0) at its south-west corner, as in OpenGL. The same for every layer of a store.
//   (s, t)   0..1 over one layer's padded square, (0, 0) at its south-west corner: the space of the virtual-texture paper's equations.
//   texels   columns from the west, rows from the north of the padded square, continuous: texel (i, j) covers [i, i+1) x [j, j+1).
#pragma once

#include "store/layer.h"

namespace vt {

struct Point2 {
  double x = 0.0;
  double y = 0.0;
};

class VtMapping {
 public:
  VtMapping(const Area& area, const LayerInfo& layer);

  // Continuous texel position on `level`. Exact formula: origin + i * step at the finest level, scaled by a
  // power of two.
  [[nodiscard]] Point2 texel_from_uv(Level level, Point2 uv) const;
  [[nodiscard]] Point2 uv_from_texel(Level level, Point2 texel) const;
  [[nodiscard]] Point2 crs_from_texel(Level level, Point2 texel) const;
  [[nodiscard]] Point2 texel_from_crs(Level level, Point2 crs) const;
  [[nodiscard]] Point2 uv_from_crs(Point2 crs) const;
  [[nodiscard]] Point2 crs_from_uv(Point2 uv) const;

  // (s, t) = scale * (u, v) + offset, per axis: what the runtime folds into its texture matrices.
  struct Affine {
    double scale_x, scale_y, offset_x, offset_y;
  };
  [[nodiscard]] Affine st_from_uv() const;

 private:
  Area area_;
  GridPlacement grid_;
  double data_x_;
  double data_y_;
  int finest_;
  int vt_exponent_;
};

}  // namespace vt
