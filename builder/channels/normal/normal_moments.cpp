#include "builder/channels/normal/normal_moments.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "builder/channels/samples/wide_value.h"

namespace vt::channels {
namespace {

// What readers get. With m the stored means, u = 2^-24 and s a second moment: the variance read is at least
// the true one plus u s, and the covariance is off by at most u / 2 of |E[Bx By]| <= sqrt(sx sy). So the
// determinant is at least that of the true matrix, which is not negative, plus (u^2 - u^2 / 4) sx sy.
struct StoredMoments {
  std::array<float, 4> along;
  float cross;
};

// The least float above `value` by one float at least.
float float_beyond(double value) { return std::nextafter(float_above(value), std::numeric_limits<float>::infinity()); }

StoredMoments stored(const SlopeMoments& moments) {
  const auto x = static_cast<float>(moments.x);
  const auto y = static_cast<float>(moments.y);
  // Roundings of the sums may leave a little less than nothing.
  const double variance_x = std::max(0.0, moments.xx - moments.x * moments.x);
  const double variance_y = std::max(0.0, moments.yy - moments.y * moments.y);
  const double most = std::sqrt(variance_x * variance_y);
  const double covariance = std::clamp(moments.xy - moments.x * moments.y, -most, most);
  return {{x, y, float_beyond(variance_x + static_cast<double>(x) * x), float_beyond(variance_y + static_cast<double>(y) * y)},
          static_cast<float>(covariance + static_cast<double>(x) * y)};
}

}  // namespace

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
    const double sx = slope_x;
    const double sy = slope_y;
    const std::array<double, kMomentCount> moments{sx, sy, sx * sx, sy * sy, sx * sy};
    for (std::size_t moment = 0; moment < kMomentCount; ++moment) {
      const double sum = static_cast<double>(w) * moments[moment];
      const auto nearest = static_cast<float>(sum);
      planes[first + 2 * moment][i] = nearest;
      planes[first + 2 * moment + 1][i] = remainder_of(sum, nearest);
    }
  }
}

SlopeMoments moments_at(const ConstPlaneRow& planes, std::size_t first, std::int64_t i) {
  const double weight = planes[3][i];
  const auto mean = [&](std::size_t moment) {
    return (static_cast<double>(planes[first + 2 * moment][i]) + static_cast<double>(planes[first + 2 * moment + 1][i])) / weight;
  };
  return {mean(0), mean(1), mean(2), mean(3), mean(4)};
}

void encode_moments(const ConstPlaneRow& planes, std::size_t first, std::int64_t count, std::byte* out) {
  for (std::int64_t i = 0; i < count; ++i) {
    std::array<float, 4> texel{kNoMoment, kNoMoment, kNoMoment, kNoMoment};
    if (planes[3][i] > 0.0F) texel = stored(moments_at(planes, first, i)).along;
    std::memcpy(out + i * static_cast<std::int64_t>(sizeof texel), texel.data(), sizeof texel);
  }
}

void encode_cross_moment(const ConstPlaneRow& planes, std::size_t first, std::int64_t count, std::byte* out) {
  for (std::int64_t i = 0; i < count; ++i) {
    const float texel = planes[3][i] > 0.0F ? stored(moments_at(planes, first, i)).cross : kNoMoment;
    std::memcpy(out + i * static_cast<std::int64_t>(sizeof texel), &texel, sizeof texel);
  }
}

double slope_variance(const std::array<double, 4>& moments) {
  return std::max(0.0, moments[2] - moments[0] * moments[0]) + std::max(0.0, moments[3] - moments[1] * moments[1]);
}

}  // namespace vt::channels
