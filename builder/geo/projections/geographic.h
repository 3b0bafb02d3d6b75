// Longitudes and latitudes themselves, in degrees from Greenwich.
#pragma once

#include <memory>
#include <span>

#include "builder/geo/projections/method.h"

namespace vt::geo {

struct Geographic {
  static constexpr MethodInfo kInfo{.name = "geographic", .title = "longitudes and latitudes", .kind = CrsKind::kGeographic};
  [[nodiscard]] static std::span<const Parameter<Geographic>> parameters() { return {}; }
  [[nodiscard]] std::unique_ptr<const Conversion> make(const Ellipsoid& ellipsoid) const;
};

}  // namespace vt::geo
