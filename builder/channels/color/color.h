// The row of color layers, see channel_kind.h. What their numbers mean and how they average is said in
// color.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kColorKind;

}  // namespace vt::channels
