// First and second moments of the slopes under a texel, from which a shader gets the roughness that a
// filtered normal lost: LEAN mapping, Olano & Baker 2010. The slopes are B = (nx / nz, ny / nz), on a height
// field minus its gradient; averages of Bx, By, Bx^2, By^2 and Bx By over any area are exact, and their
// covariance is E[B B^T] - E[B] E[B]^T. Pure functions, any thread.
//
// A covariance is the small difference of large numbers: on a slope of 5 a roughness of 0.01 is 1e-4 of 25.
// So sums are kept in double precision (wide_value.h), and moments are stored as floats: halves would lose
// all of it. They are stored as they are, not as variances, because only moments may be filtered again: what
// a texture unit blends over texels, levels and directions is the moments of the blend.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "builder/channels/codec/channel_codec.h"

namespace vt::channels {

inline constexpr std::size_t kMomentCount = 5;  // Bx, By, Bx^2, By^2, Bx By, each times weight: a plane and its remainder for each

// A normal more than 89.1 degrees from the vertical is taken as having this slope.
inline constexpr float kSteepestSlope = 64.0F;

inline constexpr float kNoMoment = std::numeric_limits<float>::quiet_NaN();

struct SlopeMoments {
  double x = 0.0;
  double y = 0.0;
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
};

// From the planes of normals (0 to 2) and their weight (3) into ten planes from `first` on.
void moments_from_normals(std::int64_t count, const PlaneRow& planes, std::size_t first);

// The texel's weight is not 0.
[[nodiscard]] SlopeMoments moments_at(const ConstPlaneRow& planes, std::size_t first, std::int64_t i);

// As floats: Bx, By, Bx^2, By^2 of each texel, and Bx By. NaN where the weight is 0. Second moments are those
// about the stored means, so that readers' covariance is the true one and not changed by how the means were
// rounded; means of squares are rounded up, by less than 2^-22 of them, so that no covariance matrix has a
// negative eigenvalue.
void encode_moments(const ConstPlaneRow& planes, std::size_t first, std::int64_t count, std::byte* out);
void encode_cross_moment(const ConstPlaneRow& planes, std::size_t first, std::int64_t count, std::byte* out);

// Bx^2 + By^2 less the squares of the means: the variance of the slopes in both directions together, of one
// texel.
[[nodiscard]] double slope_variance(const std::array<double, 4>& moments);

}  // namespace vt::channels
