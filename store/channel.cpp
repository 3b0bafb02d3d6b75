#include "store/channel.h"

#include <array>

namespace vt {
namespace {

constexpr std::array<ChannelInfo, 8> kChannels = {{
    {ChannelType::kColor, "color", "", TexelFormat::kRgb8, "weighted mean in linear light, coverage-weighted"},
    {ChannelType::kNormal, "normal", "", TexelFormat::kRgb8, "mean of unit vectors, length kept"},
    {ChannelType::kHorizon, "horizon", "rad", TexelFormat::kRgba16, "mean and variance of angles within one azimuth"},
    {ChannelType::kElevation, "elevation", "m", TexelFormat::kR32Float, "mean over valid samples"},
    {ChannelType::kMaterial, "material", "", TexelFormat::kR8, "counts per class, majority at the end"},
    {ChannelType::kSensor, "sensor", "W/(m2 sr)", TexelFormat::kR32Float, "mean of in-band radiance"},
    {ChannelType::kIllumination, "illumination", "W/(m2 sr)", TexelFormat::kRgba32Float, "mean of linear radiance"},
    {ChannelType::kMask, "mask", "", TexelFormat::kR8, "mean coverage"},
}};

}  // namespace

std::span<const ChannelInfo> all_channels() { return kChannels; }

const ChannelInfo& channel_info(ChannelType type) {
  for (const ChannelInfo& info : kChannels)
    if (info.type == type) return info;
  __builtin_unreachable();
}

std::optional<ChannelType> channel_from_number(std::uint16_t number) {
  for (const ChannelInfo& info : kChannels)
    if (static_cast<std::uint16_t>(info.type) == number) return info.type;
  return std::nullopt;
}

std::optional<ChannelType> channel_from_name(std::string_view name) {
  for (const ChannelInfo& info : kChannels)
    if (info.name == name) return info.type;
  return std::nullopt;
}

}  // namespace vt
