#include "builder/channels/coverage.h"

#include <algorithm>
#include <limits>

namespace vt::channels {

bool settle_coverage(const ConstPlaneRow& upper, const ConstPlaneRow& lower, std::span<const PlaneRule> rules, int weight_plane,
                     std::int64_t count, const PlaneRow& out) {
  const auto w = static_cast<std::size_t>(weight_plane);
  const auto box = [&](std::size_t p, std::int64_t i) {
    return 0.25F * ((upper[p][2 * i] + upper[p][2 * i + 1]) + (lower[p][2 * i] + lower[p][2 * i + 1]));
  };
  const auto for_linear_planes = [&](const auto& change) {
    for (std::size_t p = 0; p < rules.size(); ++p)
      if (rules[p] == PlaneRule::kLinear) change(p);
  };
  float* const weight = out[w];
  bool opaque = true;
  for (std::int64_t i = 0; i < count; ++i) {
    const float box_weight = box(w, i);
    if (weight[i] == 1.0F && box_weight == 1.0F) continue;
    if (box_weight <= 0.0F) {
      for_linear_planes([&](std::size_t p) { out[p][i] = 0.0F; });
    } else if (!(weight[i] >= 0.5F * box_weight)) {
      for_linear_planes([&](std::size_t p) { out[p][i] = box(p, i); });
    } else if (weight[i] > 1.0F) {
      const float excess = weight[i];
      for_linear_planes([&](std::size_t p) { out[p][i] /= excess; });
      weight[i] = 1.0F;
    }
    opaque = opaque && weight[i] == 1.0F;
  }
  return opaque;
}

void limit_to_covered(const std::array<ConstPlaneRow, 4>& rows, std::span<const PlaneRule> rules, int weight_plane, std::int64_t count,
                      const PlaneRow& out) {
  const auto w = static_cast<std::size_t>(weight_plane);
  for (std::int64_t i = 0; i < count; ++i) {
    const float weight = out[w][i];
    if (weight <= 0.0F) continue;
    for (std::size_t p = 0; p < rules.size(); ++p) {
      if (p == w || rules[p] != PlaneRule::kLinear) continue;
      float least = std::numeric_limits<float>::infinity();
      float greatest = -least;
      for (const ConstPlaneRow& row : rows)
        for (std::int64_t x = 2 * i - 1; x <= 2 * i + 2; ++x)
          if (row[w][x] > 0.0F) {
            const float value = row[w][x] == 1.0F ? row[p][x] : row[p][x] / row[w][x];
            least = std::min(least, value);
            greatest = std::max(greatest, value);
          }
      if (!(least <= greatest)) continue;  // the lobes reach data that the main lobe does not
      const float value = weight == 1.0F ? out[p][i] : out[p][i] / weight;
      const float limited = std::clamp(value, least, greatest);
      if (limited != value) out[p][i] = limited * weight;
    }
  }
}

}  // namespace vt::channels
