// Runs contenders and keeps what is measured from outside: seconds, memory, bytes, and what it takes to get
// those bytes onto the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "store/result.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/contenders.h"

namespace vt::bench {

struct Measured {
  std::vector<double> seconds;
  std::vector<double> sync_seconds;  // a sync of the result after the program has ended
  double processor_seconds = 0.0;    // of the last run
  std::uint64_t peak_bytes = 0;      // of all runs
  std::uint64_t output_bytes = 0;
  bool failed = false;  // a peer that did not run to its end: no figures

  [[nodiscard]] Spread spread() const { return spread_of(seconds); }
  [[nodiscard]] double sync_median() const { return spread_of(sync_seconds).median; }
};

// Runs to the end. Anything but exit code 0 is an error with the program's messages, and Ctrl-C is
// kCancelled.
[[nodiscard]] Result<ChildRun> run_checked(const ChildCommand& command);

// Removes an older result, makes the copy to start from, runs, syncs the result, which then lies at
// `contender.result`. A program that fails is an error with its messages.
[[nodiscard]] Result<void> run_and_keep(const Contender& contender, Measured& measured);
// The same, and removes the result.
[[nodiscard]] Result<void> run_once(const Contender& contender, Measured& measured);

// What a failure of `contender` means for a comparison: ours, and Ctrl-C, end it; a peer is noted on standard
// error, marked as failed and left out from then on.
[[nodiscard]] Result<void> accept_failure(const Contender& contender, const Error& error, Measured& measured);

// `runs` rounds in which every contender has its turn, so that a slow minute of the machine falls on all of
// them. A peer that took more than ten times as long as our build of the same job runs once only. One note a
// run on standard error.
[[nodiscard]] Result<std::vector<Measured>> run_in_turn(const std::vector<Contender>& contenders, int runs);

// The first line of `program --version`; "unknown" when it has none.
[[nodiscard]] std::string version_of(const Contender& contender, const std::filesystem::path& scratch);

// Reads a file (or all files of a folder) once, so that every contender finds it in the page cache.
[[nodiscard]] Result<void> warm_up(const std::filesystem::path& path);
// Waits until a file is on the disk, so that one contender's unwritten bytes do not slow the next one down.
[[nodiscard]] Result<void> sync_file(const std::filesystem::path& path);
// Waits until everything on the file system of `folder` is on the disk.
[[nodiscard]] Result<void> sync_file_system(const std::filesystem::path& folder);

// kIo, with both figures, when fewer bytes are free in `folder` than wanted.
[[nodiscard]] Result<void> check_room(const std::filesystem::path& folder, double wanted_bytes);

}  // namespace vt::bench
