// The form of a sensor layer that holds a whole day: classes in, the numbers of thermal_basis.h out.
#pragma once

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

// Makes the codec of settings with the option "basis". Errors as make_codec().
[[nodiscard]] MadeCodec make_thermal_codec(const ChannelSettings& settings, const SampleLayout& layout);

}  // namespace vt::channels
