// Radiance of a black body in a sensor's band, and the temperature that a radiance stands for. Temperatures
// do not add up, radiance does: layers convert with this before they average, and back afterwards. Immutable;
// any thread. Arithmetic of its own instead of the library's exponential, so that every CPU gets the same
// bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vt::channels {

// One corner of a sensor's relative spectral response, which is linear between corners and 0 before the first
// and after the last.
struct ResponsePoint {
  double wavelength_um = 0.0;
  double response = 0.0;
};

// Planck's law, W m^-2 sr^-1 um^-1: 2 h c^2 / lambda^5 / (exp(h c / (lambda k T)) - 1) with the exact
// constants of the SI of 2019. Wavelength and temperature are > 0.
[[nodiscard]] double planck_radiance(double wavelength_um, double kelvin);

class BandRadiance {
 public:
  // Ends of the table, K.
  static constexpr double kLowest = 100.0;
  static constexpr double kHighest = 3000.0;

  // At least two points, wavelengths > 0 and increasing (two equal ones make a step), responses >= 0 and not
  // all 0. Makes a table; some milliseconds.
  explicit BandRadiance(std::vector<ResponsePoint> response);

  // The integral of Planck's law times the response, W m^-2 sr^-1, by Gauss-Legendre quadrature; relative
  // error below 1e-9. Slow. 0 where it is below all doubles. `kelvin` > 0.
  [[nodiscard]] double integrate(double kelvin) const { return integrate_both(kelvin).radiance; }

  // The same from a table with cubic interpolation, fast; outside kLowest to kHighest by integrate(). From
  // 180 to 1500 K, for bands from 1 um on, off by less than what 0.1 mK makes. NaN unless `kelvin` > 0.
  [[nodiscard]] double radiance(double kelvin) const;
  // The inverse. NaN unless the radiance is > 0 (no body is as dark as 0) and not that of more than 10^7 K.
  [[nodiscard]] double temperature(double radiance) const;

 private:
  struct Sample {
    double radiance = 0.0;
    double slope = 0.0;  // per kelvin
  };
  [[nodiscard]] Sample integrate_both(double kelvin) const;
  [[nodiscard]] double search(double radiance) const;

  std::vector<ResponsePoint> response_;
  std::vector<Sample> table_;         // every kelvin
  std::vector<std::uint16_t> guide_;  // for each 64th of an octave of radiance, the last row of the table below it
  std::uint64_t guide_first_ = 0;
};

}  // namespace vt::channels
