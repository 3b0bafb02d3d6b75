// The row of normal layers, see channel_kind.h. What their numbers mean and how they average is said in
// normal.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kNormalKind;

}  // namespace vt::channels
