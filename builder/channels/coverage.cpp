#include "builder/channels/coverage.h"

namespace vt::channels {

bool settle_coverage(const ConstPlaneRow& upper, const ConstPlaneRow& lower, int planes, std::int64_t count, const PlaneRow& out) {
  const auto weight_plane = static_cast<std::size_t>(planes - 1);
  const auto box = [&](std::size_t p, std::int64_t i) {
    return 0.25F * ((upper[p][2 * i] + upper[p][2 * i + 1]) + (lower[p][2 * i] + lower[p][2 * i + 1]));
  };
  float* const weight = out[weight_plane];
  bool opaque = true;
  for (std::int64_t i = 0; i < count; ++i) {
    if (weight[i] == 1.0F && box(weight_plane, i) == 1.0F) continue;
    const float box_weight = box(weight_plane, i);
    if (box_weight <= 0.0F) {
      for (std::size_t p = 0; p <= weight_plane; ++p) out[p][i] = 0.0F;
    } else if (!(weight[i] >= 0.5F * box_weight)) {
      for (std::size_t p = 0; p <= weight_plane; ++p) out[p][i] = box(p, i);
    } else if (weight[i] > 1.0F) {
      for (std::size_t p = 0; p < weight_plane; ++p) out[p][i] /= weight[i];
      weight[i] = 1.0F;
    }
    opaque = opaque && weight[i] == 1.0F;
  }
  return opaque;
}

}  // namespace vt::channels
