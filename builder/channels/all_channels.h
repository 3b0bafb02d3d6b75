// The channels that there are. Any thread, once the program has begun.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "builder/channels/codec/channel_kind.h"

namespace vt::channels {

// In the order of their numbers, those of extra channels last.
[[nodiscard]] std::span<const ChannelKind* const> all_channels();
// The kind of a number that no row has: without options and formats, which is shown as numbers and cannot be
// made.
[[nodiscard]] const ChannelKind& kind_of(ChannelType type);
[[nodiscard]] const ChannelKind* find_channel(std::string_view name);  // null: there is none
// For people, also of numbers that no row has: "color", "channel 4711".
[[nodiscard]] std::string channel_name(ChannelType type);
[[nodiscard]] std::string channel_names();  // all of them: "color, normal, ..."

// A channel of a program's own, beside the rows of all_channels.cpp. Its number is from kFirstPrivateChannel
// on, and number and name are its alone; otherwise the program ends at once. One object of static lifetime in the program; `kind` outlives
// it.
class ExtraChannel {
 public:
  explicit ExtraChannel(const ChannelKind& kind);
};

// kUsage: an option that is of another channel, or of none; the message lists the channel's.
[[nodiscard]] Result<void> check_options(ChannelType channel, const Options& options);
// kUnsupported when the channel cannot be made from such samples or stored in such a format; the message says
// why, and what can.
[[nodiscard]] Result<std::unique_ptr<const ChannelCodec>> make_codec(const ChannelSettings& settings, const SampleLayout& layout);

}  // namespace vt::channels
