#include "builder/resample/grid/plane_block.h"

#include <algorithm>

namespace vt::resample {

using channels::PlaneRow;
using channels::PlaneRule;

void fill_with_nothing(const channels::ChannelCodec& codec, bool derived, std::int64_t count, const PlaneRow& out) {
  for (int p = 0; p < codec.source_planes(); ++p) std::fill_n(out[static_cast<std::size_t>(p)], count, 0.0F);
  if (derived) codec.derive_row(count, out);
}

std::vector<float> planes_of_nothing(const channels::ChannelCodec& codec) {
  std::vector<float> planes(static_cast<std::size_t>(codec.planes()));
  PlaneRow row{};
  for (std::size_t p = 0; p < planes.size(); ++p) row[p] = &planes[p];
  fill_with_nothing(codec, true, 1, row);
  return planes;
}

void composite_row(const PlaneRow& upper, std::span<const PlaneRule> rules, int weight_plane, std::int64_t count, const PlaneRow& lower) {
  const float* const weight = upper[static_cast<std::size_t>(weight_plane)];
  for (std::size_t p = 0; p < rules.size(); ++p) {
    const float* const from = upper[p];
    float* const to = lower[p];
    if (is_sum(rules[p])) {
      for (std::int64_t i = 0; i < count; ++i) to[i] = weight[i] == 1.0F ? from[i] : from[i] + (1.0F - weight[i]) * to[i];
      continue;
    }
    const bool is_least = rules[p] == PlaneRule::kLeast;
    for (std::int64_t i = 0; i < count; ++i) {
      if (weight[i] == 0.0F) continue;
      to[i] = weight[i] == 1.0F ? from[i] : is_least ? std::min(from[i], to[i]) : std::max(from[i], to[i]);
    }
  }
}

}  // namespace vt::resample
