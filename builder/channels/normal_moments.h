// First and second moments of the slopes under a texel, from which a shader gets the roughness that a filtered normal lost: LEAN mapping,
// Olano & Baker 2010. The slopes are B = (nx / nz, ny / nz), on a height field minus its gradient; averages of Bx, By, Bx^2, By^2 and
// Bx By over any area are exact, and their covariance is E[B B^T] - E[B] E[B]^T. Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "builder/channels/channel_codec.h"

namespace vt::channels {

inline constexpr int kMomentPlanes = 5;  // Bx, By, Bx^2, By^2, Bx By, each times weight

// A normal more than 89.1 degrees from the vertical is taken as having this slope, whose square is well within a half float.
inline constexpr float kSteepestSlope = 64.0F;

// From the planes of normals (0 to 2) and their weight (3) into five planes from `first` on.
void moments_from_normals(std::int64_t count, const PlaneRow& planes, std::size_t first);

// `components` of the planes from `first` on as half floats; quiet NaN where the weight is 0.
void encode_moments(const ConstPlaneRow& planes, std::size_t first, std::size_t components, std::int64_t count, std::byte* out);

// Bx^2 + By^2 less the squares of the means: the variance of the slopes in both directions together, of one texel.
[[nodiscard]] double slope_variance(const std::array<double, 4>& moments);

}  // namespace vt::channels
