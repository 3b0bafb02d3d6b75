// The options that channels understand, in one table: the command line makes its flags of it, scene files their keys, and each channel
// reads its own with the functions below. A new option is one row here and one line in its channel's file.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_settings.h"
#include "store/channel.h"
#include "store/result.h"

namespace vt::channels {

struct OptionInfo {
  ChannelType channel;
  std::string_view name;    // "frame": the flag --frame, the key "frame"
  std::string_view values;  // "enu|scene", "METRES", "FILE": what may follow, for --help
  std::string_view help;    // one sentence, with the default
  bool is_file = false;     // the user names a file; what is kept, and given to the channel, is the file's content
};

[[nodiscard]] std::span<const OptionInfo> all_options();
// kUsage: an option that is of another channel, or of none; the message lists the channel's.
[[nodiscard]] Result<void> check_options(ChannelType channel, const Options& options);

// The option's value or, when it is not given, `preset`. kUsage: not one of `choices`.
[[nodiscard]] Result<std::string> choice_of(const Options& options, const std::string& name, std::string_view preset,
                                            std::span<const std::string_view> choices);
// Likewise a number. kUsage: not a finite number from `least` to `greatest`.
[[nodiscard]] Result<std::optional<double>> number_of(const Options& options, const std::string& name, double least, double greatest);
// Numbers with commas between them; empty when not given.
[[nodiscard]] Result<std::vector<double>> numbers_of(const Options& options, const std::string& name);
// "yes" or "no".
[[nodiscard]] Result<bool> flag_of(const Options& options, const std::string& name, bool preset);

}  // namespace vt::channels
