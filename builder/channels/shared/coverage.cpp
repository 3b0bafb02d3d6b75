#include "builder/channels/shared/coverage.h"

#include <algorithm>
#include <limits>

namespace vt::channels {

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
