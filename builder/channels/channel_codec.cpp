#include "builder/channels/channel_codec.h"

#include <string>

namespace vt::channels {

Result<std::unique_ptr<const ChannelCodec>> make_codec(ChannelType channel, const SampleLayout& layout, Transfer transfer,
                                                       TexelFormat format) {
  switch (channel) {
    case ChannelType::kColor:
      return make_color_codec(layout, transfer, format);
    case ChannelType::kElevation:
      return make_elevation_codec(layout, format);
    case ChannelType::kNormal:
    case ChannelType::kHorizon:
    case ChannelType::kMaterial:
    case ChannelType::kSensor:
    case ChannelType::kIllumination:
    case ChannelType::kMask:
      break;
  }
  return fail(ErrorCode::kUnsupported,
              "channel '" + std::string(channel_info(channel).name) + "' cannot be built yet; color and elevation can");
}

}  // namespace vt::channels
