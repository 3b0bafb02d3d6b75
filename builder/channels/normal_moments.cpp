#include "builder/channels/normal_moments.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "store/half.h"

namespace vt::channels {

void moments_from_normals(std::int64_t count, const PlaneRow& planes, std::size_t first) {
  for (std::int64_t i = 0; i < count; ++i) {
    const float x = planes[0][i];
    const float y = planes[1][i];
    const float z = planes[2][i];
    const float w = planes[3][i];
    float slope_x = 0.0F;
    float slope_y = 0.0F;
    const float across = std::sqrt(x * x + y * y);
    if (across > 0.0F) {
      // Also where the normal looks level or down, which on a height field only noise can do.
      const float slope = z * kSteepestSlope > across ? across / z : kSteepestSlope;
      slope_x = slope * (x / across);
      slope_y = slope * (y / across);
    }
    planes[first][i] = w * slope_x;
    planes[first + 1][i] = w * slope_y;
    planes[first + 2][i] = w * (slope_x * slope_x);
    planes[first + 3][i] = w * (slope_y * slope_y);
    planes[first + 4][i] = w * (slope_x * slope_y);
  }
}

void encode_moments(const ConstPlaneRow& planes, std::size_t first, std::size_t components, std::int64_t count, std::byte* out) {
  for (std::int64_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < components; ++c, out += sizeof(std::uint16_t)) {
      const float w = planes[3][i];
      const std::uint16_t half = w > 0.0F ? half_from_float(planes[first + c][i] / w) : kHalfNoData;
      std::memcpy(out, &half, sizeof half);
    }
}

double slope_variance(const std::array<double, 4>& moments) {
  return std::max(0.0, moments[2] - moments[0] * moments[0]) + std::max(0.0, moments[3] - moments[1] * moments[1]);
}

}  // namespace vt::channels
