// The names of settings in what a program prints. A message of a library names a setting in backquotes,
// `bands`, because the same library serves scene files and other programs; a program shows its user the flag,
// --bands. Pure functions, any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace CLI {
class App;
}

namespace vt::cli {

// `text` with every backquoted name that is an option of `command` as that flag: "choose with `bands`"
// becomes "choose with --bands". Other names stay as they are.
[[nodiscard]] std::string with_flags(std::string_view text, const CLI::App& command);

// Does the same in the help of all options of `command`.
void put_flags_in_help(CLI::App& command);

// Settings that another place calls by other names, as pairs of both.
using OtherNames = std::span<const std::pair<std::string_view, std::string_view>>;
// `text` with the second name of each pair in the place of the first, still in backquotes.
[[nodiscard]] std::string with_other_names(std::string_view text, OtherNames names);

// The subcommand that the command line has chosen, or the program itself when there is none.
[[nodiscard]] const CLI::App& running_command(const CLI::App& app);

}  // namespace vt::cli
