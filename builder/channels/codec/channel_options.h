// The options that a channel understands, as rows of its ChannelKind: the command line makes its flags of
// them, scene files their keys, and the channel reads its own with the functions below. A new option is one
// row and one line in its channel's file.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "builder/channels/codec/channel_settings.h"
#include "store/result.h"

namespace vt::channels {

struct OptionInfo {
  std::string_view name;    // "frame": the flag --frame, the key "frame"
  std::string_view values;  // "enu|scene", "METRES", "FILE": what may follow, for --help
  std::string_view help;    // one sentence, with the default
  bool is_file = false;     // the user names a file; what is kept, and given to the channel, is the file's content
};

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
