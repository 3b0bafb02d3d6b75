// The row of sensor layers, see channel_kind.h. What their numbers mean and how they average is said in
// sensor.cpp.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

extern const ChannelKind kSensorKind;

}  // namespace vt::channels
