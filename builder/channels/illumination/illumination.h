// The row of illumination layers, see channel_kind.h. What their numbers mean and how they average is said in
// illumination.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kIlluminationKind;

}  // namespace vt::channels
