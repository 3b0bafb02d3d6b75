// The row of elevation layers, see channel_kind.h. What their numbers mean and how they average is said in
// elevation.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kElevationKind;

}  // namespace vt::channels
