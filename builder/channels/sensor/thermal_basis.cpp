#include "builder/channels/sensor/thermal_basis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "builder/channels/sensor/symmetric_eigen.h"
#include "builder/text/json_text.h"

namespace vt::channels {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostClasses = 65535;

std::string number_text(double value) { return Json(value).dump(); }

tl::unexpected<Error> bad(const std::string& what) { return fail(ErrorCode::kInvalidData, "thermal library: " + what); }

std::optional<std::vector<double>> numbers_in(const Json& object, const char* name) {
  if (!object.is_object() || !object.contains(name) || !object[name].is_array()) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& value : object[name]) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
    numbers.push_back(value.get<double>());
  }
  return numbers;
}

Result<std::vector<double>> hours_in(const Json& json) {
  const auto hours = numbers_in(json, "times");
  if (!hours || hours->size() < 2 || hours->size() > 288) return bad("\"times\" must be an array of 2 to 288 hours");
  for (std::size_t i = 0; i < hours->size(); ++i)
    if (!((*hours)[i] >= 0.0 && (*hours)[i] < 24.0) || (i > 0 && (*hours)[i] <= (*hours)[i - 1]))
      return bad("\"times\" must increase from 0 to below 24 hours, found " + std::to_string((*hours)[i]));
  return *hours;
}

Result<double> checked_radiance(double radiance, const std::string& name, const BandRadiance* band) {
  if (!(radiance > 0.0)) return bad(name + ": " + number_text(radiance) + " is no radiance; it has to be above 0");
  // Weights are squares of this, and are added over the classes.
  const double kelvins = kelvins_per_radiance(band, radiance);
  if (!std::isfinite(static_cast<double>(kMostClasses) * kelvins * kelvins))
    return bad(name + ": a radiance of " + number_text(radiance) + " W/(m2 sr) is no measure of temperature in this band");
  return radiance;
}

Result<double> radiance_of(double kelvin, const std::string& name, const BandRadiance& band) {
  if (!(kelvin >= BandRadiance::kLowest && kelvin <= BandRadiance::kHighest))
    return bad(name + ": a temperature of " + number_text(kelvin) + " K is outside " + number_text(BandRadiance::kLowest) + " to " +
               number_text(BandRadiance::kHighest) + " K; is it in degrees Celsius?");
  return checked_radiance(band.radiance(kelvin), name, &band);
}

Result<ThermalClass> class_in(const Json& json, std::size_t hours, bool is_temperature, const BandRadiance* band) {
  if (!json.is_object() || !json.contains("id") || !json["id"].is_number_integer()) return bad("a class has no integer \"id\"");
  ThermalClass result;
  result.id = json["id"].get<std::int64_t>();
  const std::string name = "class " + std::to_string(result.id);
  const auto curve = numbers_in(json, "curve");
  if (!curve || curve->size() != hours)
    return bad(name + ": \"curve\" must have a number for each of the " + std::to_string(hours) + " times");
  for (const double value : *curve) {
    VT_ASSIGN(const double radiance, is_temperature ? radiance_of(value, name, *band) : checked_radiance(value, name, band));
    result.radiance.push_back(radiance);
  }
  return result;
}

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

// What one curve does to the numbers of all classes, and the sign and the size that it is given.
void scale_component(ThermalBasis& basis, std::size_t k) {
  std::vector<double>& curve = basis.curves[k];
  const auto peak = std::max_element(curve.begin(), curve.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  double largest = 0.0;
  for (const std::vector<double>& c : basis.coefficients) largest = std::max(largest, std::abs(c[k]));
  const double factor = (largest > 0.0 ? largest : 1.0) * (*peak < 0.0 ? -1.0 : 1.0);
  for (double& value : curve) value *= factor;
  for (std::vector<double>& c : basis.coefficients) c[k] = c[k] / factor;
}

}  // namespace

Result<ThermalLibrary> parse_thermal_library(std::string_view library_text, const BandRadiance* band) {
  const auto parsed = text::parse_json(library_text);
  if (!parsed) return bad(parsed.error().message);
  const Json& json = *parsed;
  if (!json.is_object()) return bad("it is no JSON object");
  const std::string kind = json.value("kind", Json()).is_string() ? json["kind"].get<std::string>() : "";
  if (kind != "temperature" && kind != "radiance") return bad("\"kind\" must be \"temperature\" or \"radiance\"");
  const bool is_temperature = kind == "temperature";
  if (is_temperature && band == nullptr)
    return fail(ErrorCode::kUsage,
                "thermal library: temperatures mix as radiance in a band; give it with `band` LOW,HIGH in micrometres, "
                "for example `band` 8,12, or as a table with `response` FILE");
  ThermalLibrary library;
  VT_ASSIGN(library.hours, hours_in(json));
  if (!json.contains("classes") || !json["classes"].is_array() || json["classes"].empty() || json["classes"].size() > kMostClasses)
    return bad("\"classes\" must be an array of 1 to 65535 classes");
  for (const Json& entry : json["classes"]) {
    VT_ASSIGN(ThermalClass one, class_in(entry, library.hours.size(), is_temperature, band));
    library.classes.push_back(std::move(one));
  }
  std::sort(library.classes.begin(), library.classes.end(), [](const ThermalClass& a, const ThermalClass& b) { return a.id < b.id; });
  for (std::size_t i = 1; i < library.classes.size(); ++i)
    if (library.classes[i].id == library.classes[i - 1].id)
      return bad("class " + std::to_string(library.classes[i].id) + " is there twice");
  return library;
}

double kelvins_per_radiance(const BandRadiance* band, double radiance) {
  if (band == nullptr) return 1.0;
  const double kelvin = band->temperature(radiance);
  return 0.02 / (band->radiance(kelvin + 0.01) - band->radiance(kelvin - 0.01));
}

ThermalBasis make_thermal_basis(const ThermalLibrary& library, int components, const BandRadiance* band) {
  const std::size_t hours = library.hours.size();
  assert(components >= 1 && static_cast<std::size_t>(components) <= hours);
  ThermalBasis basis;
  basis.hours = library.hours;
  basis.mean.assign(hours, 0.0);

  // The weight of a class is the mean square of its kelvins per radiance.
  std::vector<double> weights;
  double total = 0.0;
  for (const ThermalClass& one : library.classes) {
    double weight = 0.0;
    for (const double radiance : one.radiance) {
      const double kelvins = kelvins_per_radiance(band, radiance);
      weight += kelvins * kelvins / static_cast<double>(hours);
    }
    weights.push_back(weight);
    total += weight;
    for (std::size_t t = 0; t < hours; ++t) basis.mean[t] += weight * one.radiance[t];
  }
  for (double& value : basis.mean) value /= total;

  // Principal components of the weighted differences from the mean: eigenvectors of their covariance over the
  // hours.
  std::vector<std::vector<double>> differences;
  std::vector<double> covariance(hours * hours, 0.0);
  for (std::size_t m = 0; m < library.classes.size(); ++m) {
    std::vector<double>& d = differences.emplace_back(hours);
    for (std::size_t t = 0; t < hours; ++t) d[t] = library.classes[m].radiance[t] - basis.mean[t];
    for (std::size_t i = 0; i < hours; ++i)
      for (std::size_t j = 0; j < hours; ++j) covariance[i * hours + j] += weights[m] / total * d[i] * d[j];
  }
  basis.curves = leading_eigenvectors(std::move(covariance), hours, static_cast<std::size_t>(components));

  // Curves are orthonormal, so the nearest combination is the projection.
  for (const std::vector<double>& d : differences) {
    std::vector<double>& c = basis.coefficients.emplace_back();
    for (const std::vector<double>& curve : basis.curves) c.push_back(dot(d, curve));
  }
  for (std::size_t k = 0; k < basis.curves.size(); ++k) scale_component(basis, k);
  return basis;
}

double reconstruct(const ThermalBasis& basis, std::span<const double> coefficients, double hour) {
  assert(coefficients.size() == basis.curves.size());
  const double of_day = hour - 24.0 * std::floor(hour / 24.0);
  // The last hour of the library is followed by the first of the next day.
  const std::size_t count = basis.hours.size();
  const auto next = static_cast<std::size_t>(std::upper_bound(basis.hours.begin(), basis.hours.end(), of_day) - basis.hours.begin());
  const std::size_t before = (next + count - 1) % count;
  const std::size_t after = next % count;
  const double begin = basis.hours[before] - (next == 0 ? 24.0 : 0.0);
  const double end = basis.hours[after] + (next == count ? 24.0 : 0.0);
  const double share = (of_day - begin) / (end - begin);
  const auto at = [&](const std::vector<double>& curve) { return curve[before] + share * (curve[after] - curve[before]); };
  double radiance = at(basis.mean);
  for (std::size_t k = 0; k < coefficients.size(); ++k) radiance += coefficients[k] * at(basis.curves[k]);
  return radiance;
}

BasisError basis_error(const ThermalLibrary& library, const ThermalBasis& basis, const BandRadiance* band) {
  BasisError error;
  double squares = 0.0;
  for (std::size_t m = 0; m < library.classes.size(); ++m)
    for (std::size_t t = 0; t < library.hours.size(); ++t) {
      const double wanted = library.classes[m].radiance[t];
      const double is = reconstruct(basis, basis.coefficients[m], library.hours[t]);
      // A basis of few components may go below 0, where there is no temperature; then the slope has to do.
      const double difference = band == nullptr ? is - wanted
                                : is > 0.0      ? band->temperature(is) - band->temperature(wanted)
                                                : (is - wanted) * kelvins_per_radiance(band, wanted);
      squares += difference * difference;
      error.largest = std::max(error.largest, std::abs(difference));
    }
  error.root_mean_square = std::sqrt(squares / static_cast<double>(library.classes.size() * library.hours.size()));
  return error;
}

}  // namespace vt::channels
