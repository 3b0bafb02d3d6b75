#include "builder/geo/projections/projection.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace vt::geo {
namespace {

bool is_same(ParameterKind kind, double a, double b) {
  switch (kind) {
    case ParameterKind::kLongitude:
    case ParameterKind::kLatitude:
      return std::abs(a - b) <= 1e-11;  // a micrometre on the ground
    case ParameterKind::kLength:
      return std::abs(a - b) <= 1e-6;
    case ParameterKind::kRatio:
      return std::abs(a - b) <= 1e-13 * std::abs(a);
  }
  return false;
}

bool is_possible(ParameterKind kind, double value) {
  if (!std::isfinite(value)) return false;
  switch (kind) {
    case ParameterKind::kLatitude:
      return std::abs(value) <= 90.0;
    case ParameterKind::kRatio:
      return value > 0.0;
    case ParameterKind::kLongitude:
    case ParameterKind::kLength:
      return true;
  }
  return false;
}

}  // namespace

const MethodInfo& info_of(const Projection& projection) {
  return std::visit([](const auto& method) -> const MethodInfo& { return method.kInfo; }, projection);
}

std::optional<Projection> projection_named(std::string_view name) {
  std::optional<Projection> found;
  for_each_method([&](const auto& method) {
    if (name == method.kInfo.name) found = method;
  });
  return found;
}

bool is_same(const Projection& a, const Projection& b) {
  return std::visit(
      [&]<class Method>(const Method& method) {
        const auto* const other = std::get_if<Method>(&b);
        if (other == nullptr) return false;
        for (const Parameter<Method>& parameter : Method::parameters())
          if (!is_same(parameter.kind, method.*parameter.value, other->*parameter.value)) return false;
        return true;
      },
      a);
}

void write_parameters(const Projection& projection, nlohmann::json& json) {
  std::visit(
      [&]<class Method>(const Method& method) {
        for (const Parameter<Method>& parameter : Method::parameters()) json[parameter.json_key] = method.*parameter.value;
      },
      projection);
}

void read_parameters(const nlohmann::json& json, Projection& projection) {
  std::visit(
      [&]<class Method>(Method& method) {
        for (const Parameter<Method>& parameter : Method::parameters())
          if (const auto value = json.find(parameter.json_key); value != json.end()) value->get_to(method.*parameter.value);
      },
      projection);
}

std::string problem_of(const Projection& projection) {
  return std::visit(
      []<class Method>(const Method& method) {
        for (const Parameter<Method>& parameter : Method::parameters())
          if (!is_possible(parameter.kind, method.*parameter.value))
            return fmt::format("a {} with a {} of {} is impossible", Method::kInfo.title, parameter.label, method.*parameter.value);
        if constexpr (requires { method.problem(); }) return std::string(method.problem());
        return std::string();
      },
      projection);
}

std::unique_ptr<const Conversion> conversion_of(const Projection& projection, const Ellipsoid& ellipsoid) {
  return std::visit([&](const auto& method) { return method.make(ellipsoid); }, projection);
}

}  // namespace vt::geo
