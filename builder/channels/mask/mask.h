// The row of mask layers, see channel_kind.h. What their numbers mean and how they average is said in
// mask.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kMaskKind;

}  // namespace vt::channels
