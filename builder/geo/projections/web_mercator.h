// EPSG:3857: the spherical formulas of Mercator over ellipsoidal latitudes, on the ellipsoid's semi-major
// axis (EPSG method 1024).
#pragma once

#include <memory>
#include <span>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct WebMercator {
  static constexpr MethodInfo kInfo{.name = "web_mercator", .title = "Web Mercator", .only_epsg = 3857};
  [[nodiscard]] static std::span<const Parameter<WebMercator>> parameters() { return {}; }
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid& ellipsoid) const;
};

}  // namespace vt::geo
