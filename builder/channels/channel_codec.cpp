#include "builder/channels/channel_codec.h"

#include <algorithm>
#include <string>

#include "builder/channels/channel_makers.h"
#include "builder/channels/channel_options.h"

namespace vt::channels {

void ChannelCodec::derive_row(std::int64_t, const PlaneRow&) const {}

bool ChannelCodec::has_data(std::size_t, const ConstPlaneRow& planes, std::int64_t count) const {
  const float* const weights = planes[static_cast<std::size_t>(weight_plane())];
  return std::any_of(weights, weights + count, [](float weight) { return weight > 0.0F; });
}

Result<int> bands_wanted(ChannelType channel, const Options&, int values) {
  switch (channel) {
    case ChannelType::kColor:
    case ChannelType::kIllumination:
      return values >= 3 ? 3 : 1;
    case ChannelType::kNormal:
      return values >= 3 ? 3 : 2;
    case ChannelType::kHorizon:
      return values;
    case ChannelType::kElevation:
    case ChannelType::kMaterial:
    case ChannelType::kSensor:
    case ChannelType::kMask:
      return 1;
  }
  return 1;
}

bool takes_coverage(ChannelType channel) {
  return channel == ChannelType::kColor || channel == ChannelType::kIllumination || channel == ChannelType::kMask;
}

bool is_coverage_itself(ChannelType channel, int values) { return channel == ChannelType::kMask && values > 1; }

Result<std::unique_ptr<const ChannelCodec>> make_codec(const ChannelSettings& settings, const SampleLayout& layout) {
  VT_CHECK(check_options(settings.channel, settings.options));
  switch (settings.channel) {
    case ChannelType::kColor:
      return make_color_codec(settings, layout);
    case ChannelType::kElevation:
      return make_elevation_codec(settings, layout);
    case ChannelType::kMaterial:
      return make_material_codec(settings, layout);
    case ChannelType::kMask:
      return make_mask_codec(settings, layout);
    case ChannelType::kSensor:
      return make_sensor_codec(settings, layout);
    case ChannelType::kIllumination:
      return make_illumination_codec(settings, layout);
    case ChannelType::kNormal:
      return make_normal_codec(settings, layout);
    case ChannelType::kHorizon:
      return make_horizon_codec(settings, layout);
  }
  __builtin_unreachable();
}

}  // namespace vt::channels
