// The rule for texels that are only partly covered by data: normalised convolution that stays finite with negative kernel lobes.
// Works on premultiplied planes, so that a plain weighted sum is already sum(w m v), sum(w m). Any thread.
#pragma once

#include <cstdint>

#include "builder/channels/channel_codec.h"

namespace vt::channels {

// `out` holds `count` filtered texels (planes and weight, the last of `planes`); `upper` and `lower` are the two source rows under them,
// texel i over source columns 2i and 2i + 1. Per texel, with box = mean of the four source texels under it:
//   - no data under it (box weight 0): it becomes no data, so data never grow;
//   - the lobes left less than half of the box weight: the box takes over, because dividing by so little would amplify noise;
//   - weight above 1 (lobes cut off at an edge): planes are scaled down to weight 1.
// Returns whether every weight is exactly 1.
bool settle_coverage(const ConstPlaneRow& upper, const ConstPlaneRow& lower, int planes, std::int64_t count, const PlaneRow& out);

}  // namespace vt::channels
