// The row of material layers, see channel_kind.h. What their numbers mean and how they average is said in
// material.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kMaterialKind;

}  // namespace vt::channels
