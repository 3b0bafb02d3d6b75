#include "tools/cli/cli_support.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <deque>
#include <exception>
#include <iostream>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "store/format/text.h"
#include "store/io/mapping.h"
#include "tools/cli/setting_names.h"

namespace vt::cli {

namespace {

constexpr int kUsageExit = 1;
constexpr int kIoExit = 2;
constexpr int kInvalidDataExit = 3;
constexpr int kInternalExit = 4;
constexpr int kInterruptedExit = 130;

// Standard output refuses more bytes; thrown by print() and caught by run_main() only.
struct OutputFailed {
  int error_number;
};

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0) throw OutputFailed{errno};
}

std::atomic<bool>& interrupt_flag_storage() {
  static std::atomic<bool> flag{false};
  return flag;
}

// A number from 0 to 2 that the caller closed would go to the next file that is opened, and what is printed
// would be written into it.
void occupy_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd)
    // The lowest free number is this one, since those below are taken.
    if (::fcntl(fd, F_GETFD) == -1 && errno == EBADF) static_cast<void>(::open("/dev/null", O_RDWR));
}

extern "C" void on_interrupt(int) { interrupt_flag_storage().store(true, std::memory_order_relaxed); }

// Exactly out.size() numbers between separators; nothing before, between or behind them.
template <class Number>
Result<void> parse_list(std::string_view text, std::string_view option, std::string_view form, std::span<Number> out, char separator) {
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto [stop, error] = std::from_chars(at, end, out[i]);
    const bool is_last = i + 1 == out.size();
    const bool ends_well = is_last ? stop == end : stop != end && *stop == separator;
    if (error != std::errc() || !ends_well) {
      return fail(ErrorCode::kUsage, fmt::format("{}: found \"{}\", wanted {}", option, text, form));
    }
    if constexpr (std::is_floating_point_v<Number>) {
      if (!std::isfinite(out[i])) return fail(ErrorCode::kUsage, fmt::format("{}: \"{}\" is not finite", option, text));
    }
    at = stop + 1;
  }
  return {};
}

int report(const CLI::App& app, const Error& error) {
  print_note(app.get_name(), with_flags(error.message, running_command(app)));
  return exit_code(error.code);
}

// "vtbuild layer": what is typed before options.
std::string command_line_of(const CLI::App& app) {
  const CLI::App& command = running_command(app);
  return &command == &app ? app.get_name() : app.get_name() + " " + command.get_name();
}

}  // namespace

int exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return kUsageExit;
    case ErrorCode::kIo:
    case ErrorCode::kNotFound:
    case ErrorCode::kExists:
      return kIoExit;
    case ErrorCode::kInvalidData:
    case ErrorCode::kUnsupported:
    case ErrorCode::kCorrupt:
      return kInvalidDataExit;
    case ErrorCode::kCancelled:
      return kInterruptedExit;
    case ErrorCode::kInternal:
      return kInternalExit;
  }
  return kInternalExit;
}

void add_help_footer(CLI::App& app, std::string_view examples) {
  app.footer(
      fmt::format("\nExamples:\n{}\n\nExit codes:\n"
                  "  0 fine; 1 wrong usage; 2 input or output failed; 3 invalid data; 4 internal error; 130 stopped by Ctrl-C",
                  examples));
}

int run_main(CLI::App& app, int argc, const char* const* argv, const std::function<Result<int>()>& command) {
  const std::string program = app.get_name();
  occupy_standard_streams();
  // A reader that goes away and a file over its size limit are then errors of the write, not signals that
  // kill us in the middle of something.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  store::guard_mappings();
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) {  // --help, --version
        std::ostringstream text;
        app.exit(error, text, text);
        print(text.str());
        flush_output();
        return 0;
      }
      print_note(program, fmt::format("{}\nRun `{} --help` to see what is accepted.", error.what(), command_line_of(app)));
      return kUsageExit;
    }
    const Result<int> result = command();
    const int code = result ? *result : report(app, result.error());
    flush_output();
    return code;
  } catch (const OutputFailed& failure) {
    if (failure.error_number != EPIPE) {
      print_note(program, fmt::format("standard output: cannot write: {}", std::strerror(failure.error_number)));
    }
    return kIoExit;
  } catch (const std::bad_alloc&) {
    return report(app,
                  {ErrorCode::kIo, "not enough memory; a smaller --memory, where there is one, or a smaller part at a time needs less"});
  } catch (const std::system_error& error) {
    return report(app, {ErrorCode::kIo, fmt::format("the system refused something that is needed: {}", error.what())});
  } catch (const std::exception& error) {
    return report(app, {ErrorCode::kInternal, fmt::format("internal error, please report it: {}", error.what())});
  } catch (...) {
    return report(app, {ErrorCode::kInternal, "internal error, please report it: unknown exception"});
  }
}

void print(std::string_view text) {
  errno = 0;
  const std::string shown = store::printable_lines(text);
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size()) throw OutputFailed{errno};
}

void print_json(const nlohmann::ordered_json& document) {
  // Names in a damaged store may be any bytes; JSON is UTF-8.
  // What print() spells out in a string is JSON's own way to write it.
  print(document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

void print_note(std::string_view program, std::string_view text) {
  const std::string line = fmt::format("{}: {}\n", program, store::printable_lines(text));
  // Nothing sensible can be done when standard error is closed.
  std::fwrite(line.data(), 1, line.size(), stderr);
}

const std::atomic<bool>& interrupt_flag() {
  static const bool installed = [] {
    struct sigaction action = {};
    action.sa_handler = on_interrupt;
    action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    return true;
  }();
  static_cast<void>(installed);
  return interrupt_flag_storage();
}

Result<void> parse_numbers(std::string_view text, std::string_view option, std::string_view form, std::span<double> out) {
  return parse_list(text, option, form, out, ',');
}

Result<void> parse_integers(std::string_view text, std::string_view option, std::string_view form, std::span<std::int64_t> out,
                            char separator) {
  return parse_list(text, option, form, out, separator);
}

std::string format_bytes(std::uint64_t bytes) { return format_bytes_of(static_cast<double>(bytes)); }

std::string format_bytes_of(double bytes) {
  constexpr std::array kUnits = {"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  if (bytes < 1024.0) return fmt::format("{:.0f} B", bytes);
  double value = bytes;
  std::size_t unit = 0;
  while (value >= 1023.95 && unit + 1 < kUnits.size()) {  // 1023.95 would print as 1024.0
    value /= 1024.0;
    ++unit;
  }
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string format_quantity(double value) {
  constexpr std::array kPrefixes = {"", " k", " M", " G", " T", " P"};
  std::size_t prefix = 0;
  while (std::abs(value) >= 999.5 && prefix + 1 < kPrefixes.size()) {
    value /= 1000.0;
    ++prefix;
  }
  if (prefix == 0 && value == std::floor(value)) return fmt::format("{:.0f}", value);
  const double size = std::abs(value);
  const int decimals = size >= 99.95 ? 0 : size >= 9.995 ? 1 : 2;
  return fmt::format("{:.{}f}{}", value, decimals, kPrefixes[prefix]);
}

std::string format_duration(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::clamp(std::round(seconds), 0.0, 1e12));
  const std::int64_t hours = whole / 3600;
  const std::int64_t minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

std::string format_exact(double value) { return fmt::format("{:.17g}", value); }

Result<ProgressMode> progress_mode_from_name(std::string_view name) {
  if (name == "auto") return ProgressMode::kAuto;
  if (name == "plain") return ProgressMode::kPlain;
  if (name == "none") return ProgressMode::kNone;
  return fail(ErrorCode::kUsage, "--progress is auto, plain or none, not '" + std::string(name) + "'");
}

struct Progress::Impl {
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::milliseconds kRedrawEvery{100};
  static constexpr std::chrono::seconds kLineEvery{5};
  static constexpr std::chrono::milliseconds kLinesApart{500};
  static constexpr std::chrono::seconds kRateSamplesApart{1};
  static constexpr std::size_t kRateSamples = 15;  // the rate is that of about the last 15 seconds

  struct Sample {
    Clock::time_point time;
    std::uint64_t done;
  };

  explicit Impl(ProgressOptions given) : options(std::move(given)), total(options.total) {
    if (!options.clock) options.clock = [] { return Clock::now(); };
    const bool is_terminal = options.out_is_terminal.value_or(options.out == nullptr && isatty(STDERR_FILENO) == 1);
    if (options.out == nullptr) options.out = &std::cerr;
    options.title = store::printable(options.title);
    silent = options.mode == ProgressMode::kNone;
    bar = options.mode == ProgressMode::kAuto && is_terminal;
  }

  [[nodiscard]] int columns() const {
    if (options.terminal_columns > 0) return options.terminal_columns;
    winsize size = {};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
    return 80;
  }

  // Units per second over the recent past; 0 while there is nothing to divide by.
  [[nodiscard]] double rate(Clock::time_point now) const {
    if (samples.empty()) return 0.0;
    const double seconds = std::chrono::duration<double>(now - samples.front().time).count();
    return seconds > 0.0 ? static_cast<double>(done - samples.front().done) / seconds : 0.0;
  }

  // By the rate of the whole run, which errs less about the future than that of a moment: sea and land take
  // turns.
  [[nodiscard]] double seconds_left(Clock::time_point now) const {
    const double seconds = std::chrono::duration<double>(now - first->time).count();
    const auto progressed = static_cast<double>(done - first->done);
    return progressed > 0.0 ? static_cast<double>(total - done) * seconds / progressed : 0.0;
  }

  [[nodiscard]] std::string status(Clock::time_point now) const {
    const double per_second = rate(now);
    std::string text;
    if (total > 0) {
      text = fmt::format("{:3.0f} %  {}/{} {}", std::floor(100.0 * fraction()), done, total, options.unit);
    } else {
      text = fmt::format("{} {}", done, options.unit);
    }
    if (per_second > 0.0) {
      text += fmt::format("  {}/s", format_quantity(per_second));
      if (total > done) text += fmt::format("  {} left", format_duration(seconds_left(now)));
    }
    return text;
  }

  [[nodiscard]] double fraction() const { return total == 0 ? 0.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total)); }

  void draw_bar(Clock::time_point now) {
    const std::string text = status(now);
    const int width = columns() - 1;  // the last column would make some terminals wrap
    const int cells = std::min(30, width - static_cast<int>(options.title.size() + text.size()) - 6);
    std::string line = options.title + "  ";
    if (total > 0 && cells >= 8) {
      const int full = static_cast<int>(fraction() * cells);
      line += '[' + std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(cells - full), '.') + "] ";
    }
    line += text;
    if (static_cast<int>(line.size()) > width) line.resize(static_cast<std::size_t>(std::max(width, 1)));
    *options.out << '\r' << line << "\x1b[K" << std::flush;  // erase what a longer line left behind
    line_open = true;
  }

  void draw(Clock::time_point now) {
    if (bar) {
      draw_bar(now);
    } else {
      *options.out << options.title << ": " << status(now) << '\n' << std::flush;
    }
    last_drawn = now;
    drawn_tenth = static_cast<int>(fraction() * 10.0);
  }

  [[nodiscard]] bool is_due(Clock::time_point now) const {
    if (!last_drawn) return bar;  // a log does not need "0 %" of work that is over in a moment
    if (bar) return now - *last_drawn >= kRedrawEvery;
    const bool new_tenth = static_cast<int>(fraction() * 10.0) > drawn_tenth;
    return now - *last_drawn >= kLineEvery || (new_tenth && now - *last_drawn >= kLinesApart);
  }

  void take_sample(Clock::time_point now) {
    if (!samples.empty() && now - samples.back().time < kRateSamplesApart) return;
    samples.push_back({now, done});
    if (samples.size() > kRateSamples) samples.pop_front();
  }

  ProgressOptions options;
  bool silent = false;
  bool bar = false;

  std::mutex mutex;  // guards everything below
  std::uint64_t total = 0;
  std::uint64_t done = 0;
  std::optional<Sample> first;
  std::deque<Sample> samples;
  std::optional<Clock::time_point> last_drawn;
  int drawn_tenth = 0;
  bool line_open = false;
  bool finished = false;
};

Progress::Progress(ProgressOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}

Progress::~Progress() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->line_open) *impl_->options.out << '\n' << std::flush;
}

void Progress::update(std::uint64_t done) {
  if (impl_->silent) return;
  const std::unique_lock lock(impl_->mutex, std::try_to_lock);
  if (!lock || impl_->finished) return;
  const auto now = impl_->options.clock();
  impl_->done = std::max(impl_->done, done);
  if (!impl_->first) {
    impl_->first = Impl::Sample{now, impl_->done};
    if (!impl_->bar) impl_->last_drawn = now;  // the first line of a log comes after the first wait
  }
  if (impl_->is_due(now)) impl_->draw(now);
  impl_->take_sample(now);
}

void Progress::set_total(std::uint64_t total) {
  const std::lock_guard lock(impl_->mutex);
  impl_->total = total;
}

void Progress::note(std::string_view text) {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->line_open) *impl_->options.out << "\r\x1b[K";
  *impl_->options.out << store::printable_lines(text) << '\n' << std::flush;
  if (impl_->line_open) impl_->draw_bar(impl_->options.clock());
}

void Progress::finish() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->silent || impl_->finished) return;
  impl_->finished = true;
  const Impl::Sample first = impl_->first.value_or(Impl::Sample{impl_->options.clock(), impl_->done});
  if (impl_->total > 0) impl_->done = impl_->total;
  const double seconds = std::chrono::duration<double>(impl_->options.clock() - first.time).count();
  std::string line = fmt::format("{}: {} {}", impl_->options.title, impl_->done, impl_->options.unit);
  if (first.done > 0) line += fmt::format(" ({} of them before this run)", first.done);
  line += fmt::format(" in {:.1f} s", seconds);
  if (seconds > 0.0) line += fmt::format(", {}/s", format_quantity(static_cast<double>(impl_->done - first.done) / seconds));
  if (impl_->line_open) *impl_->options.out << "\r\x1b[K";
  *impl_->options.out << line << '\n' << std::flush;
  impl_->line_open = false;
}

}  // namespace vt::cli
