// The rule for texels that are only partly covered by data: normalised convolution that stays finite with negative kernel lobes.
// Works on premultiplied planes, so that a plain weighted sum is already sum(w m v), sum(w m). Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "builder/channels/channel_codec.h"

namespace vt::channels {

// `out` holds `count` filtered texels; `upper` and `lower` are the two source rows under them, texel i over source columns 2i and 2i + 1.
// Per texel, with box = mean of the four source texels under it, in all planes whose rule is linear:
//   - no data under it (box weight 0): it becomes no data, so data never grow;
//   - the lobes left less than half of the box weight: the box takes over, because dividing by so little would amplify noise;
//   - weight above 1 (lobes cut off at an edge): planes are scaled down to weight 1.
// Returns whether every weight is exactly 1.
bool settle_coverage(const ConstPlaneRow& upper, const ConstPlaneRow& lower, std::span<const PlaneRule> rules, int weight_plane,
                     std::int64_t count, const PlaneRow& out);

// For partly covered texels what pyramid's limit_to_four_rows does for opaque ones: each linear plane's value (plane / weight) moves
// between the least and the greatest value of the texels with data among the four rows at 2i - 1 to 2i + 2; the weight stays.
void limit_to_covered(const std::array<ConstPlaneRow, 4>& rows, std::span<const PlaneRule> rules, int weight_plane, std::int64_t count,
                      const PlaneRow& out);

}  // namespace vt::channels
