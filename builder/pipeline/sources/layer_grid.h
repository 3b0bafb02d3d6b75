// Where a layer's finest grid lies and how large it is: chosen from what is asked for and from what the
// sources are. Arithmetic only; any thread.
#pragma once

#include <cmath>
#include <optional>

#include "builder/geo/crs.h"
#include "builder/pipeline/request/layer_request.h"
#include "builder/pipeline/sources/open_sources.h"
#include "store/layer.h"
#include "store/result.h"
#include "store/vt_mapping.h"

namespace vt::pipeline {

// Texels by which a source's grid may miss the layer's and still count as the same grid: far below what
// resampling could express.
inline constexpr double kGridTolerance = 1e-4;

struct Bounds {
  double west = INFINITY, south = INFINITY, east = -INFINITY, north = -INFINITY;
  void add(Point2 p);
  void add(const Bounds& other);
};

// From one CRS to another on the ground; longitudes of `from` do not jump at the antimeridian.
[[nodiscard]] Result<Point2> convert(const geo::Crs& to, const geo::Crs& from, Point2 p);

// Outer bounds of a source in the layer's CRS. Where that has turns, in the turn that the source itself
// counts in, and a source across the antimeridian is one piece. kInvalidData: it cannot be placed there.
[[nodiscard]] Result<Bounds> bounds_in(const geo::Crs& crs, const OpenSource& source);

// The grid: the first source's own where that is possible, so that its samples become texels as they are.
// Without a source (null) the request has a ground sample distance. `first_moved_x`: the source lies so far
// east of where it says.
[[nodiscard]] Result<GridPlacement> choose_grid(const LayerRequest& request, const geo::Crs& crs, const OpenSource* first,
                                                double first_moved_x, const Bounds& bounds);

// Sets the data rectangle and the number of levels from the grid and the bounds; needs the tile exponent.
// kInvalidData when the pyramid would be too large.
[[nodiscard]] Result<void> set_size(const Bounds& bounds, LayerInfo& info);

// Whether columns of `width` texels of `step_x` are the whole circle of longitudes, to a thousandth of a
// texel.
[[nodiscard]] bool closes_around_globe(const geo::Crs& crs, std::int64_t width, double step_x);

}  // namespace vt::pipeline
