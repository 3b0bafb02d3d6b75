// A day of thermal radiance in a few numbers that may be filtered. Every material of a library radiates
// L_m(t) over the hours of a day; those curves lie near a few common ones, L_m(t) = phi_0(t) + sum over k of
// c_mk phi_k(t). A place that is a mixture of materials with shares f_m radiates sum of f_m L_m(t), so its
// numbers are sum of f_m c_mk: they average like radiance, and any hour comes back from them. The phi are
// principal components of the library. Pure functions and plain values; any thread; the same bits on every
// CPU.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "builder/channels/sensor/planck.h"
#include "store/result.h"

namespace vt::channels {

struct ThermalClass {
  std::int64_t id = 0;
  std::vector<double> radiance;  // at every hour of the library, W/(m2 sr)
};

struct ThermalLibrary {
  std::vector<double> hours;          // 2 to 288, from 0 to below 24, increasing
  std::vector<ThermalClass> classes;  // 1 to 65535, ids increasing
};

// JSON: {"kind": "temperature" (K) or "radiance" (W/(m2 sr)), "times": [hours], "classes": [{"id": 1,
// "curve": [a number for each time]}]}. Other keys are passed over. `band` turns temperatures into radiance;
// it may be null for radiance. Temperatures are from 100 to 3000 K. kInvalidData: anything else, and a
// radiance that is none of a temperature in the band or so little that the square of kelvins_per_radiance()
// is no double, with the class that is wrong; kUsage: temperatures without a band.
[[nodiscard]] Result<ThermalLibrary> parse_thermal_library(std::string_view text, const BandRadiance* band);

struct ThermalBasis {
  std::vector<double> hours;
  std::vector<double> mean;                       // phi_0 at every hour, W/(m2 sr)
  std::vector<std::vector<double>> curves;        // phi_k likewise, the one that explains most first
  std::vector<std::vector<double>> coefficients;  // c_mk: for each class of the library, from -1 to 1
};

// How many kelvins of a black body one more W/(m2 sr) is at a radiance; 1 without a band.
[[nodiscard]] double kelvins_per_radiance(const BandRadiance* band, double radiance);

// 1 to as many components as there are hours. With a band, an error counts by the kelvins that it makes of
// each class's own temperature, so that cold materials are not lost beside hot ones; without one, by
// radiance. Where a curve could as well be its negative, its largest number is positive.
[[nodiscard]] ThermalBasis make_thermal_basis(const ThermalLibrary& library, int components, const BandRadiance* band);

// The radiance at an hour, between the hours of the library linearly; days follow one another, so any finite
// hour will do. `coefficients`: one for each curve.
[[nodiscard]] double reconstruct(const ThermalBasis& basis, std::span<const double> coefficients, double hour);

// How far the library itself lies from its basis, over all classes and hours: kelvins with a band, W/(m2 sr)
// without. In radiance a mixture is never further off than the worst of its materials.
struct BasisError {
  double root_mean_square = 0.0;
  double largest = 0.0;
};
[[nodiscard]] BasisError basis_error(const ThermalLibrary& library, const ThermalBasis& basis, const BandRadiance* band);

}  // namespace vt::channels
