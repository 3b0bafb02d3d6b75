// What a number in a layer means. The channel type decides how values combine (builder/channels) and is never guessed from pixel values.
#pragma once

#include <cstdint>

namespace vt {

// The registered numbers, which are on disk. Append; never renumber, never reuse. A store may hold others, of newer programs or from
// kFirstPrivateChannel on: any number is a valid ChannelType. What is known of each is builder/channels/all_channels.h's to say.
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

// Numbers from here on are for channels of one's own: nobody registers them, and two programs may use one number for two things.
inline constexpr std::uint16_t kFirstPrivateChannel = 0x8000;

}  // namespace vt
