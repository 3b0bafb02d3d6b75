// The row of horizon layers, see channel_kind.h. What their numbers mean and how they average is said in
// horizon.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kHorizonKind;

}  // namespace vt::channels
