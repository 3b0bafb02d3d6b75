// The makers of the eight channels' codecs, one file each. Private to this room and its tests; others call make_codec(). Errors as there.
#pragma once

#include <memory>

#include "builder/channels/codec/channel_codec.h"

namespace vt::channels {

using MadeCodec = Result<std::unique_ptr<const ChannelCodec>>;

[[nodiscard]] MadeCodec make_color_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_normal_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_horizon_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_elevation_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_material_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_sensor_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_illumination_codec(const ChannelSettings& settings, const SampleLayout& layout);
[[nodiscard]] MadeCodec make_mask_codec(const ChannelSettings& settings, const SampleLayout& layout);

}  // namespace vt::channels
