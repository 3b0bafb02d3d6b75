// Equations 2 to 7 of the virtual-texture paper for one axis, word for word: what the transforms of
// runtime/paging.h are held against. Names without a comment of their own are the paper's; `paper_level` 0 is
// the finest.
#pragma once

#include <cmath>

#include "runtime/paging.h"

namespace vt::runtime {

// Equation 3: the tile's lower left corner from dimensions.
[[nodiscard]] inline double lower_left_from_dimensions(double center, double dim_tile, int paper_level, double dim_vt) {
  return center - dim_tile * std::ldexp(1.0, paper_level - 1) / dim_vt;
}
// Equation 4: the same from exponents.
[[nodiscard]] inline double lower_left_from_exponents(double center, int tile, int paper_level, int vt) {
  return center - std::ldexp(1.0, tile + paper_level - 1 - vt);
}

// Equation 2: solved from its two known pairs, center -> 0.5 and lower left corner -> 0.
[[nodiscard]] inline Linear transform_from_pairs(double center, double lower_left) {
  const double scale = 0.5 / (center - lower_left);
  return {scale, 0.5 - scale * center};
}
// Equation 5, whose constant term is equation 7.
[[nodiscard]] inline Linear transform_from_exponents(double center, int tile, int paper_level, int vt) {
  const double scale = std::ldexp(1.0, vt - paper_level - tile);
  return {scale, 0.5 - scale * center};
}

struct Interval {
  double min = 0.0;
  double max = 0.0;
};
// Equation 6: the extent of a level (or tile) of `dim` texels around its center.
[[nodiscard]] inline Interval extent_around(double center, double dim, int paper_level, double dim_vt) {
  const double half = 0.5 * dim * std::ldexp(1.0, paper_level) / dim_vt;
  return {center - half, center + half};
}

}  // namespace vt::runtime
