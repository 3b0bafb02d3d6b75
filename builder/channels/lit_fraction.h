// How much of a surface the sun reaches when the horizon of its points is normally distributed: Phi((s - mean) / sqrt(deviation^2 +
// sun^2)), s the sun's elevation, the sun's disc smoothing the edge of the shadow by its own deviation. The same bits on every CPU. Pure
// functions, any thread.
#pragma once

#include <numbers>

namespace vt::channels {

// The sun's disc has half a degree across; the share of it above a straight horizon rises like the normal distribution of this deviation.
inline constexpr double kSunDeviationRad = 0.13 * std::numbers::pi / 180.0;

// The standard normal distribution function, to 2e-6.
[[nodiscard]] double normal_distribution(double z);

// 0 to 1; radians, `deviation` >= 0. Nothing is divided by 0: the sun has a deviation of its own.
[[nodiscard]] double lit_fraction(double sun_elevation, double mean, double deviation);

}  // namespace vt::channels
