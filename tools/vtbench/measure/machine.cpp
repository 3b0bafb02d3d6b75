#include "tools/vtbench/measure/machine.h"

#include <fmt/format.h>
#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "tools/cli/cli_support.h"

namespace vt::bench {

std::string Machine::text() const { return fmt::format("{}, {} cores, {}", cpu, cores, cli::format_bytes(memory_bytes)); }

Machine this_machine() {
  Machine machine;
  machine.cpu = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      machine.cpu = line.substr(colon + 2);
      break;
    }
  }
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  machine.cores =
      sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  machine.memory_bytes = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return machine;
}

void warn_about_conditions() {
#ifndef NDEBUG
  cli::print_note("vtbench", "built with assertions; figures to publish come from the release preset");
#endif
  std::array<double, 1> load{};
  if (getloadavg(load.data(), 1) == 1 && load[0] > 0.25 * this_machine().cores)
    cli::print_note("vtbench", fmt::format("other programs were busy in the last minute (load {:.2f}); figures may be too low", load[0]));
}

Spread spread_of(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
  return {median, values.front(), values.back()};
}

Result<ScratchFolder> ScratchFolder::create(const std::filesystem::path& parent) {
  std::error_code problem;
  const std::filesystem::path where = parent.empty() ? std::filesystem::temp_directory_path(problem) : parent;
  if (!problem) std::filesystem::create_directories(where, problem);
  if (problem) return fail(ErrorCode::kIo, where.string() + ": cannot be made: " + problem.message());
  std::string pattern = (where / "vtbench-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr)
    return fail(ErrorCode::kIo, where.string() + ": no folder can be made in it: " + std::strerror(errno) + "; choose another --scratch");
  return ScratchFolder(pattern);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

Result<std::string> read_text_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) return fail(ErrorCode::kIo, path.string() + ": cannot be read: " + std::strerror(errno));
  return text.str();
}

Result<void> check_interrupt() {
  if (cli::interrupt_flag()) return fail(ErrorCode::kCancelled, "stopped; nothing was written");
  return {};
}

}  // namespace vt::bench
