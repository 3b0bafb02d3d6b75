// Longitude is a circle: where coordinates come again after a whole turn (geo::Crs::turn), these say by how
// many turns an area or a source is moved so that it lies with what it belongs to. Arithmetic only; any
// thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "builder/geo/crs.h"
#include "builder/pipeline/sources/layer_grid.h"
#include "store/layer.h"
#include "store/result.h"

namespace vt::pipeline {

[[nodiscard]] std::string area_text(const Area& area);

// The rectangle that a user means: one whose west is greater than its east lies across the antimeridian.
// kUsage: `area` is no rectangle, or none on the Earth in degrees.
[[nodiscard]] Result<Bounds> bounds_of(const Area& area, const geo::Crs& crs);
[[nodiscard]] Result<Area> normalised(const Area& area, const geo::Crs& crs);

// `box` moved to the east.
[[nodiscard]] Bounds moved_by(const Bounds& box, double x);

// Turns after which `box` has texels in common with `area`, 0 first, then by their number.
[[nodiscard]] std::vector<int> turns_into(const Bounds& box, const Bounds& area, double turn);

// How the sources of a layer lie together.
struct Gathering {
  std::vector<int> turns;  // by which each source is moved to the east
  Bounds bounds;           // of the layer
};
// Sources stay where they say they lie, with two exceptions. Sources on both sides of the antimeridian come
// together when that makes the layer less than half as wide. And in a store that has an area, a layer outside
// it comes inside, and what sticks out on one side comes in on the other: then the layer ends at the store's
// edges.
[[nodiscard]] Gathering gathered(std::span<const Bounds> boxes, double turn, const std::optional<Bounds>& store_area);

}  // namespace vt::pipeline
