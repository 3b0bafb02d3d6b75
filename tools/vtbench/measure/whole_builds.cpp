#include "tools/vtbench/measure/whole_builds.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tools/cli/cli_support.h"

namespace vt::bench {
namespace {

constexpr double kSlowPeer = 10.0;  // times our own build

Result<void> read_to_the_end(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY);
  std::vector<char> buffer(std::size_t{1} << 20);
  ssize_t got = fd < 0 ? -1 : 1;
  while (got > 0) got = ::read(fd, buffer.data(), buffer.size());
  if (fd >= 0) ::close(fd);
  if (got < 0) return fail(ErrorCode::kIo, path.string() + ": cannot be read");
  return {};
}

}  // namespace

Result<void> sync_file(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY);
  const bool ok = fd >= 0 && ::fsync(fd) == 0;
  if (fd >= 0) ::close(fd);
  if (!ok) return fail(ErrorCode::kIo, path.string() + ": cannot be synced to the disk");
  return {};
}

Result<void> sync_file_system(const std::filesystem::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  const bool ok = fd >= 0 && ::syncfs(fd) == 0;
  if (fd >= 0) ::close(fd);
  if (!ok) return fail(ErrorCode::kIo, folder.string() + ": cannot be synced to the disk");
  return {};
}

Result<ChildRun> run_checked(const ChildCommand& command) {
  VT_ASSIGN(const ChildRun child, run_child(command));
  VT_CHECK(check_interrupt());
  if (child.exit_code != 0)
    return fail(ErrorCode::kIo, fmt::format("exit code {} from: {}\n{}", child.exit_code, shell_text(command.arguments),
                                            read_text_file(command.errors).value_or("")));
  return child;
}

Result<void> run_and_keep(const Contender& contender, Measured& measured) {
  std::error_code problem;
  std::filesystem::remove(contender.result, problem);
  std::uint64_t bytes_before = 0;
  if (contender.starts_from) {
    std::filesystem::copy_file(*contender.starts_from, contender.result, problem);
    if (problem) return fail(ErrorCode::kIo, contender.result.string() + ": cannot copy the input: " + problem.message());
    VT_CHECK(sync_file(contender.result));
    bytes_before = std::filesystem::file_size(contender.result);
  }
  VT_ASSIGN(const ChildRun child, run_checked(contender.command));
  Result<void> synced;
  measured.sync_seconds.push_back(seconds_of([&] { synced = sync_file(contender.result); }));
  VT_CHECK(synced);
  measured.seconds.push_back(child.seconds);
  measured.processor_seconds = child.processor_seconds;
  measured.peak_bytes = std::max(measured.peak_bytes, child.peak_bytes);
  measured.output_bytes = std::filesystem::file_size(contender.result) - bytes_before;
  return {};
}

Result<void> run_once(const Contender& contender, Measured& measured) {
  VT_CHECK(run_and_keep(contender, measured));
  std::error_code problem;
  std::filesystem::remove(contender.result, problem);
  if (problem) return fail(ErrorCode::kIo, contender.result.string() + ": cannot be removed: " + problem.message());
  return {};
}

Result<void> accept_failure(const Contender& contender, const Error& error, Measured& measured) {
  if (contender.is_ours || error.code == ErrorCode::kCancelled) return tl::unexpected(error);
  cli::print_note("vtbench", contender.name + " is left out: " + error.message);
  measured = {};
  measured.failed = true;
  return {};
}

Result<std::vector<Measured>> run_in_turn(const std::vector<Contender>& contenders, int runs) {
  std::vector<Measured> measured(contenders.size());
  for (int round = 0; round < runs; ++round) {
    double our_seconds = 0.0;  // contenders of a job follow our own build
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      if (measured[i].failed) continue;
      const bool is_slow = round > 0 && !contenders[i].is_ours && measured[i].seconds.front() > kSlowPeer * our_seconds;
      if (is_slow) continue;
      if (const auto ran = run_once(contenders[i], measured[i]); !ran) {
        VT_CHECK(accept_failure(contenders[i], ran.error(), measured[i]));
        continue;
      }
      if (contenders[i].is_ours) our_seconds = measured[i].seconds.front();
      cli::print_note("vtbench", fmt::format("round {} of {}: {}, {}: {:.2f} s", round + 1, runs, contenders[i].job, contenders[i].name,
                                             measured[i].seconds.back()));
    }
  }
  return measured;
}

std::string version_of(const Contender& contender, const std::filesystem::path& scratch) {
  ChildCommand command;
  command.arguments = {contender.command.arguments.front(), "--version"};
  command.output = command.errors = scratch / "version.txt";
  const auto run = run_child(command);
  const auto text = read_text_file(command.output);
  return run && run->exit_code == 0 && text ? text->substr(0, text->find('\n')) : "unknown";
}

Result<void> warm_up(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return read_to_the_end(path);
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    VT_CHECK(check_interrupt());
    VT_CHECK(read_to_the_end(entry.path()));
  }
  return {};
}

Result<void> check_room(const std::filesystem::path& folder, double wanted_bytes) {
  std::error_code problem;
  const auto space = std::filesystem::space(folder, problem);
  if (problem) return fail(ErrorCode::kIo, folder.string() + ": its free space is unknown: " + problem.message());
  if (static_cast<double>(space.available) < wanted_bytes)
    return fail(ErrorCode::kIo,
                fmt::format("{}: {} are free, {} are wanted; choose another --scratch", folder.string(), cli::format_bytes(space.available),
                            cli::format_bytes(static_cast<std::uint64_t>(wanted_bytes))));
  return {};
}

}  // namespace vt::bench
