// The inner loops of resampling, a run of samples or texels at a time; SIMD with run-time dispatch. Additions
// and multiplications only, so every CPU gives the same bits as the plain loops. Private to this folder. Any
// thread.
#pragma once

#include <cstddef>

namespace vt::resample {

// sums[i] += weight * values[i], in double.
void add_weighted(const float* values, double weight, std::size_t count, double* sums);

// Texels whose four samples follow each other as the texels do: texel i lies `fraction_x[i]` from the western
// ones of samples i, and `fraction_y[i]` from the northern ones.
struct FourSamples {
  const float* fraction_x;
  const float* fraction_y;
  const float* north_west;
  const float* north_east;
  const float* south_west;
  const float* south_east;
};
// out[i] = n + fraction_y (s - n), n and s being the northern and the southern two mixed likewise by
// fraction_x.
void interpolate(const FourSamples& samples, std::size_t count, float* out);

}  // namespace vt::resample
