#include "builder/channels/sensor/planck.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace vt::channels {
namespace {

// CODATA 2018, all three exact: h = 6.62607015e-34 J s, c = 299792458 m/s, k = 1.380649e-23 J/K.
constexpr double kFirst = 2.0 * 6.62607015e-34 * 299792458.0 * 299792458.0 * 1e24;  // 2 h c^2, W um^4 m^-2 sr^-1
constexpr double kSecond = 6.62607015e-34 * 299792458.0 / 1.380649e-23 * 1e6;       // h c / k, um K

constexpr double kHottest = 1e7;
constexpr int kGuideShift = 52 - 6;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// exp(-x) for x >= 0: x = n ln 2 + r, then the power series of r up to the 14th power, of which |r| <= 0.35
// leaves 1e-18.
double exp_of_minus(double x) {
  if (x > 708.0) return 0.0;
  constexpr double kLn2High = 0x1.62e42fee00000p-1;  // 32 bits, so that its product with n is exact
  constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
  const double n = std::floor(x * 1.4426950408889634 + 0.5);
  const double r = -((x - n * kLn2High) - n * kLn2Low);
  double sum = 1.0;
  for (int i = 14; i >= 1; --i) sum = 1.0 + sum * r / i;
  return std::ldexp(sum, -static_cast<int>(n));
}

// The positive abscissas of the eight-point Gauss-Legendre rule on -1 to 1, and their weights (Abramowitz and
// Stegun, table 25.4).
constexpr std::array<double, 4> kAbscissas{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> kWeights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

// So much longer is the end of a panel than its begin, at most.
constexpr double kPanelRatio = 1.06;

}  // namespace

double planck_radiance(double wavelength_um, double kelvin) {
  const double exponential = exp_of_minus(kSecond / (wavelength_um * kelvin));
  const double square = wavelength_um * wavelength_um;
  return kFirst / (square * square * wavelength_um) * exponential / (1.0 - exponential);
}

BandRadiance::BandRadiance(std::vector<ResponsePoint> response) : response_(std::move(response)) {
  assert(response_.size() >= 2);
  for (double kelvin = kLowest; kelvin <= kHighest; kelvin += 1.0) table_.push_back(integrate_both(kelvin));
  // Bands of visible light have no radiance at all in the lowest rows; those are left to the search.
  guide_first_ = std::bit_cast<std::uint64_t>(table_.front().radiance) >> kGuideShift;
  const std::uint64_t last = std::bit_cast<std::uint64_t>(table_.back().radiance) >> kGuideShift;
  std::size_t row = 0;
  for (std::uint64_t bin = guide_first_; bin <= last + 1; ++bin) {
    const auto begin = std::bit_cast<double>(bin << kGuideShift);
    while (row + 1 < table_.size() && table_[row + 1].radiance <= begin) ++row;
    guide_.push_back(static_cast<std::uint16_t>(row));
  }
}

BandRadiance::Sample BandRadiance::integrate_both(double kelvin) const {
  Sample sum;
  for (std::size_t i = 0; i + 1 < response_.size(); ++i) {
    const ResponsePoint& from = response_[i];
    const ResponsePoint& to = response_[i + 1];
    if (to.wavelength_um <= from.wavelength_um || (from.response == 0.0 && to.response == 0.0)) continue;
    const double rise = (to.response - from.response) / (to.wavelength_um - from.wavelength_um);
    for (double begin = from.wavelength_um; begin < to.wavelength_um; begin *= kPanelRatio) {
      const double half = (std::min(begin * kPanelRatio, to.wavelength_um) - begin) / 2.0;
      for (std::size_t k = 0; k < 2 * kAbscissas.size(); ++k) {
        const double abscissa = k % 2 == 0 ? kAbscissas[k / 2] : -kAbscissas[k / 2];
        const double wavelength = begin + half * (1.0 + abscissa);
        const double x = kSecond / (wavelength * kelvin);
        const double weight = half * kWeights[k / 2] * (from.response + rise * (wavelength - from.wavelength_um));
        const double radiance = weight * planck_radiance(wavelength, kelvin);
        sum.radiance += radiance;
        sum.slope += radiance * x / kelvin / (1.0 - exp_of_minus(x));
      }
    }
  }
  return sum;
}

double BandRadiance::radiance(double kelvin) const {
  if (!(kelvin > 0.0)) return kNaN;
  if (kelvin < kLowest || kelvin >= kHighest) return integrate(kelvin);
  const double row = kelvin - kLowest;
  const auto i = static_cast<std::size_t>(row);
  const double t = row - static_cast<double>(i);
  // Hermite's cubic through both rows and their slopes, in the rows' distance of 1 K.
  const Sample& a = table_[i];
  const Sample& b = table_[i + 1];
  const double rise = b.radiance - a.radiance;
  const double c2 = 3.0 * rise - 2.0 * a.slope - b.slope;
  const double c3 = a.slope + b.slope - 2.0 * rise;
  return a.radiance + t * (a.slope + t * (c2 + t * c3));
}

double BandRadiance::temperature(double radiance) const {
  if (!(radiance > 0.0)) return kNaN;
  if (radiance < table_.front().radiance || radiance >= table_.back().radiance) return search(radiance);
  const std::uint64_t bin = (std::bit_cast<std::uint64_t>(radiance) >> kGuideShift) - guide_first_;
  const auto first = table_.begin() + guide_[bin];
  const auto last = table_.begin() + std::min<std::ptrdiff_t>(guide_[bin + 1] + 2, static_cast<std::ptrdiff_t>(table_.size()));
  const auto above = std::upper_bound(first, last, radiance, [](double value, const Sample& sample) { return value < sample.radiance; });
  const Sample& a = *(above - 1);
  const Sample& b = *above;
  const double rise = b.radiance - a.radiance;
  const double c2 = 3.0 * rise - 2.0 * a.slope - b.slope;
  const double c3 = a.slope + b.slope - 2.0 * rise;
  const double wanted = radiance - a.radiance;
  // Newton on the cubic; a kelvin is so short that three steps end at rounding.
  double t = wanted / rise;
  for (int step = 0; step < 3; ++step) t -= (t * (a.slope + t * (c2 + t * c3)) - wanted) / (a.slope + t * (2.0 * c2 + 3.0 * t * c3));
  return kLowest + static_cast<double>(above - 1 - table_.begin()) + std::clamp(t, 0.0, 1.0);
}

// Where the table does not reach: bisection, in the exponent first because temperatures far apart are
// possible.
double BandRadiance::search(double radiance) const {
  double low = 1e-3;
  double high = kHottest;
  if (radiance > integrate(high)) return kNaN;
  if (radiance <= integrate(low)) return low;
  while (high - low > 1e-9 * high) {
    const double middle = high > 2.0 * low ? std::sqrt(low * high) : (low + high) / 2.0;
    (integrate(middle) < radiance ? low : high) = middle;
  }
  return (low + high) / 2.0;
}

}  // namespace vt::channels
