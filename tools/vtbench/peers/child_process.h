// Runs another program and measures it from outside: wall clock, processor time, peak resident memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "store/result.h"

namespace vt::bench {

struct ChildCommand {
  std::vector<std::string> arguments;                            // the first is the program's path
  std::vector<std::pair<std::string, std::string>> environment;  // beside what we have ourselves
  std::filesystem::path output;                                  // receives standard output
  std::filesystem::path errors;                                  // receives standard error; may be the same file
};

struct ChildRun {
  int exit_code = 0;  // 128 + signal when it was killed
  double seconds = 0.0;
  double processor_seconds = 0.0;  // user and system, all threads
  // The system counts a program's peak from the fork on, so it is never below the private memory of this
  // process (some 45 MiB, most of it tables of shared libraries): measure children before allocating anything
  // large. smallest_peak_bytes() says how much it is.
  std::uint64_t peak_bytes = 0;
};

// Waits for the end. kIo when the program cannot be started; an exit code other than 0 is for the caller to
// judge.
[[nodiscard]] Result<ChildRun> run_child(const ChildCommand& command);

// The peak of a program that does nothing: what cannot be told from our own memory. 0 when even that cannot
// be run.
[[nodiscard]] std::uint64_t smallest_peak_bytes();

// As a shell would find it; nullopt when it is not installed.
[[nodiscard]] std::optional<std::filesystem::path> find_program(const std::string& name);
// A program of ours, in the folder of the running one. kIo when it is not there.
[[nodiscard]] Result<std::filesystem::path> program_beside(const std::string& name);

// For people to paste: arguments with anything but plain characters are quoted.
[[nodiscard]] std::string shell_text(const std::vector<std::string>& arguments);

}  // namespace vt::bench
