// What a number in a layer means. The channel type decides how values combine (builder/channels) and is never guessed from pixel values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "store/texel_format.h"

namespace vt {

// Numbers are on disk. Append; never renumber, never reuse.
enum class ChannelType : std::uint16_t {
  kColor = 1,
  kNormal = 2,
  kHorizon = 3,
  kElevation = 4,
  kMaterial = 5,
  kSensor = 6,
  kIllumination = 7,
  kMask = 8,
};

// What the codes of an integer colour format mean; numbers are on disk.
enum class Transfer : std::uint8_t {
  kLinear = 0,  // the value is proportional to light (or is no light at all, such as metres)
  kSrgb = 1,    // IEC 61966-2-1
};

struct ChannelInfo {
  ChannelType type;
  std::string_view name;  // as on the command line
  std::string_view unit;  // "" where there is none
  TexelFormat default_format;
  std::string_view combine_rule;  // one phrase for people
};

[[nodiscard]] std::span<const ChannelInfo> all_channels();
[[nodiscard]] const ChannelInfo& channel_info(ChannelType type);
[[nodiscard]] std::optional<ChannelType> channel_from_number(std::uint16_t number);
[[nodiscard]] std::optional<ChannelType> channel_from_name(std::string_view name);

}  // namespace vt
