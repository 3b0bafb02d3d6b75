#include "tools/cli/setting_names.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>

namespace vt::cli {
namespace {

bool is_setting_name(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; });
}

// `text` with what `replacement` gives for each backquoted name, quotes and all. An empty string leaves the
// name as it is.
std::string with_names_replaced(std::string_view text, const std::function<std::string(std::string_view)>& replacement) {
  std::string result;
  while (true) {
    const std::size_t open = text.find('`');
    const std::size_t close = open == std::string_view::npos ? open : text.find('`', open + 1);
    if (close == std::string_view::npos) return result.append(text);
    result += text.substr(0, open);
    const std::string_view name = text.substr(open + 1, close - open - 1);
    const std::string other = is_setting_name(name) ? replacement(name) : std::string();
    // A backquote that opens no name may be part of a path; the next one may open a name all the same.
    result += other.empty() ? "`" : other;
    text.remove_prefix(other.empty() ? open + 1 : close + 1);
  }
}

}  // namespace

std::string with_flags(std::string_view text, const CLI::App& command) {
  return with_names_replaced(text, [&](std::string_view name) {
    const std::string flag = "--" + std::string(name);
    return command.get_option_no_throw(flag) == nullptr ? std::string() : flag;
  });
}

void put_flags_in_help(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) option->description(with_flags(option->get_description(), command));
}

std::string with_other_names(std::string_view text, OtherNames names) {
  return with_names_replaced(text, [&](std::string_view name) {
    const auto found = std::ranges::find(names, name, &OtherNames::element_type::first);
    return found == names.end() ? std::string() : "`" + std::string(found->second) + "`";
  });
}

const CLI::App& running_command(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app : running_command(*chosen.front());
}

}  // namespace vt::cli
