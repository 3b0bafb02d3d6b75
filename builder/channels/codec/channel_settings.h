// Everything about a layer's channel that a user may choose. Plain values; what is possible together is each
// channel's affair.
#pragma once

#include <limits>
#include <map>
#include <string>

#include "store/channel.h"
#include "store/texel_format.h"

namespace vt::channels {

// Choices of one channel by their names in channel_options.h, as text: "frame" -> "enu". An option that is
// not there has its default.
using Options = std::map<std::string, std::string>;

struct ChannelSettings {
  ChannelType channel = ChannelType::kColor;
  TexelFormat format = TexelFormat::kRgb8;                          // of the first part
  Transfer transfer = Transfer::kLinear;                            // of the codes that are stored
  double source_nodata = std::numeric_limits<double>::quiet_NaN();  // of the layer's first source; NaN: none
  bool samples_are_wide = false;                                    // numbers of some source of the layer are, see wide_value.h
  double stored_light = 1.0;  // of illumination whose options do not say so: the light of the number 1 in the store
  Options options;
};

}  // namespace vt::channels
