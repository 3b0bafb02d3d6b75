// The limit to ringing for texels that are only partly covered by data. Works on planes that are multiplied
// by their weights. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "builder/channels/codec/channel_codec.h"

namespace vt::channels {

// For partly covered texels what pyramid's limit_to_four_rows does for opaque ones: each linear plane's value
// (plane / weight) moves between the least and the greatest value of the texels with data among the four rows
// at 2i - 1 to 2i + 2; the weight stays.
void limit_to_covered(const std::array<ConstPlaneRow, 4>& rows, std::span<const PlaneRule> rules, int weight_plane, std::int64_t count,
                      const PlaneRow& out);

}  // namespace vt::channels
