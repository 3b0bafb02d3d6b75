// No place on the Earth: x counts east and y north, in raster units. Has nothing to convert.
#pragma once

#include <memory>
#include <span>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct Pixel {
  static constexpr MethodInfo kInfo{.name = "pixel", .title = "pixel coordinates", .kind = CrsKind::kPixel};
  [[nodiscard]] static std::span<const Parameter<Pixel>> parameters() { return {}; }
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid&) const { return nullptr; }
};

}  // namespace vt::geo
