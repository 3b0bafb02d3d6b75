// What the subcommands of vtbench share: the machine's name, medians, a scratch folder, files of results.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "store/result.h"

namespace vt::bench {

inline constexpr double kMib = 1024.0 * 1024.0;

// What a figure must be read with. No date and no host name: results of the same machine compare equal as
// text.
struct Machine {
  std::string cpu;
  int cores = 0;  // that the process may run on
  std::uint64_t memory_bytes = 0;
  [[nodiscard]] std::string text() const;  // "Intel Xeon, 2 cores, 7.8 GiB"
};
[[nodiscard]] Machine this_machine();

// Says on standard error what makes figures doubtful: assertions compiled in, other programs on the cores.
void warn_about_conditions();

struct Spread {
  double median = 0.0;
  double min = 0.0;
  double max = 0.0;
};
// The spread of at least one value. The median of an even count is the mean of the middle two.
[[nodiscard]] Spread spread_of(std::vector<double> values);

// Seconds of the steady clock that `work` takes.
template <class Work>
[[nodiscard]] double seconds_of(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A new folder inside `parent` (empty: the system's temporary folder), removed with everything in it.
class ScratchFolder {
 public:
  [[nodiscard]] static Result<ScratchFolder> create(const std::filesystem::path& parent);
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~ScratchFolder();
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(std::string_view name) const { return path_ / name; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path);

// kCancelled when Ctrl-C was pressed.
[[nodiscard]] Result<void> check_interrupt();

}  // namespace vt::bench
