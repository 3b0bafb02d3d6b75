// Row loops of normals: vectors to unit vectors, and their means to direction and length. SIMD, run-time
// dispatch; every CPU target gives the same bits. Pure functions, any thread.
#pragma once

#include <cstddef>

namespace vt::channels {

// A mean of unit vectors shorter than this has no direction of its own: the normals under it cancel.
inline constexpr float kLeastLength = 1e-3F;

// Makes each of `count` vectors a unit vector with weight 1; one whose components are all smaller than
// `least`, or are not all finite, becomes zero with weight 0. Returns whether every weight is 1.
bool make_unit(std::size_t count, float least, float* x, float* y, float* z, float* weight);

struct DirectionRows {
  float* x;
  float* y;
  float* z;
  float* length;
};

// The direction of each of `count` sums of weighted unit vectors, and the length of their mean, from 0 to 1.
// Where the mean is shorter than kLeastLength the direction is 0, 0, 0; where there is no weight the length
// is -1 as well.
void direction_and_length(std::size_t count, const float* x, const float* y, const float* z, const float* weight, const DirectionRows& out);

}  // namespace vt::channels
