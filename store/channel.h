// What a number in a layer means. The channel type decides how values combine (builder/channels) and is never
// guessed from pixel values. A ChannelType may hold any number: a store that a newer program wrote has
// channels that this program does not know, and its texels are still texels. So nothing here fails for such a
// number. What is known of each is builder/channels/all_channels.h's to say.
#pragma once

#include <cstdint>

namespace vt {

// The registered numbers, which are on disk. Append; never renumber, never reuse. 0 is no channel.
enum class ChannelType : std::uint16_t {
  kColor = 1,
  kNormal = 2,
  kHorizon = 3,
  kElevation = 4,
  kMaterial = 5,
  kSensor = 6,
  kIllumination = 7,
  kMask = 8,
  kLastRegistered = kMask,  // goes with the last one
};
[[nodiscard]] constexpr bool is_registered(ChannelType type) { return type != ChannelType{} && type <= ChannelType::kLastRegistered; }

// Numbers from here on are never registered: they are for channels that a user adds in a program of their
// own.
inline constexpr std::uint16_t kFirstPrivateChannel = 0x8000;
[[nodiscard]] constexpr bool is_private(ChannelType type) { return static_cast<std::uint16_t>(type) >= kFirstPrivateChannel; }

// What the codes of an integer colour format mean; numbers are on disk.
enum class Transfer : std::uint8_t {
  kLinear = 0,  // the value is proportional to light (or is no light at all, such as metres)
  kSrgb = 1,    // IEC 61966-2-1
};

}  // namespace vt
