// What every command-line program of this project does the same way: exit codes, error lines, help footers,
// numbers in arguments, JSON output, progress, Ctrl-C. Results go to standard output, everything else to
// standard error. Progress may be updated from any thread; the rest is for the main thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "store/result.h"

namespace CLI {
class App;
}

namespace vt::cli {

// 0 fine, 1 usage, 2 input/output, 3 invalid data, 4 internal; 130 when the user stopped the program, as
// shells report Ctrl-C.
[[nodiscard]] int exit_code(ErrorCode code);

// The last paragraphs of --help: `examples` (one command a line, each indented by two spaces), then the exit
// codes.
void add_help_footer(CLI::App& app, std::string_view examples);

// Parses the command line and runs `command`, whose value is the exit code. Everything that can go wrong ends
// here, as a line `program: message` and an exit code: parse errors 1, an Error by its code, lack of memory
// or threads 2, any other escaped exception 4. Settings that a message names are printed as flags of the
// running subcommand (tools/cli/setting_names.h). --help and --version print and give 0. Writing to a pipe
// whose reader has gone ends the program with exit code 2 and no message. Standard streams that the caller
// has closed are the null device from here on, a file over the size limit (ulimit -f) is a failed write, and
// a store that is cut off under its reader an Error (store/io/mapping.h). Call it before any file is opened.
[[nodiscard]] int run_main(CLI::App& app, int argc, const char* const* argv, const std::function<Result<int>()>& command);

// Standard output. Leaves run_main's `command` when nothing more can be written, so no caller has to check.
// Characters of names, paths and metadata that would steer a terminal are spelled out, here and wherever else
// this header prints (store/format/text.h); line feeds and tabs are the layout's. A value that must not have
// those either goes through store::printable() first.
void print(std::string_view text);
void print_json(const nlohmann::ordered_json& document);
// A line `program: text` on standard error, for facts that do not stop the program.
void print_note(std::string_view program, std::string_view text);

// After the first call, the first Ctrl-C (or SIGTERM) sets the flag and leaves the program running; the
// second ends it at once.
[[nodiscard]] const std::atomic<bool>& interrupt_flag();

// "1,2.5" to numbers, exactly as many as `out` has. kUsage: the message names `option` and shows `form`.
[[nodiscard]] Result<void> parse_numbers(std::string_view text, std::string_view option, std::string_view form, std::span<double> out);
[[nodiscard]] Result<void> parse_integers(std::string_view text, std::string_view option, std::string_view form,
                                          std::span<std::int64_t> out, char separator = ',');

[[nodiscard]] std::string format_bytes(std::uint64_t bytes);  // "12.3 MiB"
[[nodiscard]] std::string format_bytes_of(double bytes);      // the same of more than 64 bits hold
[[nodiscard]] std::string format_quantity(double value);      // "12.3 M", three significant digits, decimal prefixes
[[nodiscard]] std::string format_duration(double seconds);    // "0:07", "1:02:03"
[[nodiscard]] std::string format_exact(double value);         // 17 significant digits: reads back as the same double

enum class ProgressMode : std::uint8_t {
  kAuto,   // a bar on a terminal, plain lines elsewhere
  kPlain,  // lines for a log
  kNone,
};
// Of --progress. kUsage: the name is none.
[[nodiscard]] Result<ProgressMode> progress_mode_from_name(std::string_view name);

struct ProgressOptions {
  ProgressMode mode = ProgressMode::kAuto;
  std::string title;        // "building colour"
  std::string unit;         // "tiles"
  std::uint64_t total = 0;  // 0: not known yet, see set_total()

  // Replaced by tests; null means the steady clock, standard error and what the system says about it.
  std::function<std::chrono::steady_clock::time_point()> clock = nullptr;
  std::ostream* out = nullptr;
  std::optional<bool> out_is_terminal = std::nullopt;
  int terminal_columns = 0;  // 0: ask the terminal
};

// Shows how far long work has come, with its recent rate and the time left. On a terminal one line is redrawn
// at most ten times a second; in a log there is a line every five seconds and at every tenth of the work, but
// never more than two a second. Call update() once before the work starts, with what an earlier run had done:
// the rate counts from there.
class Progress {
 public:
  explicit Progress(ProgressOptions options);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  // ends an open line; says nothing about success

  // Any thread. Values that come late and smaller are ignored. Costs a clock reading; a thread that finds
  // another one drawing goes on.
  void update(std::uint64_t done);
  void set_total(std::uint64_t total);
  // Prints a line of its own without tearing the bar.
  void note(std::string_view text);
  // All is done; prints how much, how long, how fast. Later updates are ignored. Not for work that failed:
  // just let the object go.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vt::cli
