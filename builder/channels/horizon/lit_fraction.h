// How much of a surface the sun reaches when the horizon of its points is normally distributed: Phi((s -
// mean) / sqrt(deviation^2 + sun^2)), s the sun's elevation, the sun's disc smoothing the edge of the shadow
// by its own deviation. The same bits on every CPU. Pure functions, any thread.
#pragma once

#include <cmath>
#include <numbers>

namespace vt::channels {

// The sun's disc has half a degree across; the share of it above a straight horizon rises like the normal
// distribution of this deviation.
inline constexpr double kSunDeviationRad = 0.13 * std::numbers::pi / 180.0;

// The standard normal distribution function, to 2e-6.
[[nodiscard]] double normal_distribution(double z);

// The lit fraction under one distribution of horizons, for several places of the sun. Radians, `deviation` >=
// 0. Nothing is divided by 0: the sun has a deviation of its own.
class LitCurve {
 public:
  LitCurve(double mean, double deviation)
      : mean_(mean), steepness_(1.0 / std::sqrt(deviation * deviation + kSunDeviationRad * kSunDeviationRad)) {}
  // 0 to 1.
  [[nodiscard]] double at(double sun_elevation) const { return normal_distribution((sun_elevation - mean_) * steepness_); }

 private:
  double mean_;
  double steepness_;
};

[[nodiscard]] inline double lit_fraction(double sun_elevation, double mean, double deviation) {
  return LitCurve(mean, deviation).at(sun_elevation);
}

}  // namespace vt::channels
