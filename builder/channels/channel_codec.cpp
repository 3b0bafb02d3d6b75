#include "builder/channels/channel_codec.h"

#include <string>

#include "builder/channels/channel_makers.h"
#include "builder/channels/channel_options.h"

namespace vt::channels {

void ChannelCodec::derive_row(std::int64_t, const PlaneRow&) const {}

Result<std::unique_ptr<const ChannelCodec>> make_codec(const ChannelSettings& settings, const SampleLayout& layout) {
  VT_CHECK(check_options(settings.channel, settings.options));
  switch (settings.channel) {
    case ChannelType::kColor:
      return make_color_codec(settings, layout);
    case ChannelType::kElevation:
      return make_elevation_codec(settings, layout);
    case ChannelType::kNormal:
    case ChannelType::kHorizon:
    case ChannelType::kMaterial:
    case ChannelType::kSensor:
    case ChannelType::kIllumination:
    case ChannelType::kMask:
      break;
  }
  return fail(ErrorCode::kUnsupported,
              "channel '" + std::string(channel_info(settings.channel).name) + "' cannot be built yet; color and elevation can");
}

}  // namespace vt::channels
