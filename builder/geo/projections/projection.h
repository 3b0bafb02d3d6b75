// The projection of a coordinate reference system: one of the methods of this folder with its parameters. The
// only list of methods there is; everything that is done with all of them is here, and follows from what each
// says of itself in method.h. Values, any thread.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "builder/geo/projections/cylindrical_equal_area.h"
#include "builder/geo/projections/geographic.h"
#include "builder/geo/projections/mercator.h"
#include "builder/geo/projections/method.h"
#include "builder/geo/projections/pixel.h"
#include "builder/geo/projections/transverse_mercator.h"
#include "builder/geo/projections/web_mercator.h"

namespace vt::geo {

using Projection = std::variant<Pixel, Geographic, TransverseMercator, WebMercator, Mercator, CylindricalEqualArea>;

// Calls use(method) with every method, its parameters at their defaults.
template <class Use, std::size_t... kIndex>
void for_each_method(const Use& use, std::index_sequence<kIndex...>) {
  (use(std::variant_alternative_t<kIndex, Projection>{}), ...);
}
template <class Use>
void for_each_method(const Use& use) {
  for_each_method(use, std::make_index_sequence<std::variant_size_v<Projection>>{});
}

[[nodiscard]] const MethodInfo& info_of(const Projection& projection);
// nullopt: no method of this name in JSON. Parameters are at their defaults.
[[nodiscard]] std::optional<Projection> projection_named(std::string_view name);

// The same method, and every parameter the same within a micrometre on the ground.
[[nodiscard]] bool is_same(const Projection& a, const Projection& b);

// Keys of an object; those that are absent stand for defaults, and Crs::from_json() refuses what is
// unknown, but for words. Reading throws nlohmann::json::exception where a value is no number.
void write_parameters(const Projection& projection, nlohmann::json& json);
void read_parameters(const nlohmann::json& json, Projection& projection);

// Why no conversion can be made of the parameters; "" where one can.
[[nodiscard]] std::string problem_of(const Projection& projection);
// nullptr where there is nothing to convert. Throws what GeographicLib throws.
[[nodiscard]] std::unique_ptr<const Conversion> conversion_of(const Projection& projection, const Ellipsoid& ellipsoid);

}  // namespace vt::geo
