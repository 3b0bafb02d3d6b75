#include "tools/vtbench/peers/child_process.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>

namespace vt::bench {
namespace {

// In the child, between fork and exec, where only calls that are safe in a signal handler are allowed.
// Returns only on failure.
void become(const char* const* arguments, const char* const* environment, const char* output, const char* errors, bool one_file) {
  const int out = ::open(output, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err = one_file ? out : ::open(errors, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int in = ::open("/dev/null", O_RDONLY);
  if (out < 0 || err < 0 || in < 0) return;
  if (::dup2(in, STDIN_FILENO) < 0 || ::dup2(out, STDOUT_FILENO) < 0 || ::dup2(err, STDERR_FILENO) < 0) return;
  // We ignore these, and that would be inherited.
  std::signal(SIGPIPE, SIG_DFL);
  std::signal(SIGXFSZ, SIG_DFL);
  ::execve(arguments[0], const_cast<char* const*>(arguments), const_cast<char* const*>(environment));
}

std::vector<const char*> pointers_to(const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  pointers.push_back(nullptr);
  return pointers;
}

double seconds_from(const timeval& time) { return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec); }

}  // namespace

Result<ChildRun> run_child(const ChildCommand& command) {
  std::vector<std::string> environment;
  for (const auto& [name, value] : command.environment) environment.push_back(name + "=" + value);
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    bool replaced = false;
    for (const auto& added : command.environment) replaced = replaced || text.starts_with(added.first + "=");
    if (!replaced) environment.emplace_back(text);
  }
  const auto arguments = pointers_to(command.arguments);
  const auto environment_pointers = pointers_to(environment);

  // Tells us why exec failed; closed by itself when it succeeds.
  int failure_pipe[2];
  if (::pipe2(failure_pipe, O_CLOEXEC) != 0) return fail(ErrorCode::kIo, std::string("no pipe: ") + std::strerror(errno));

  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    become(arguments.data(), environment_pointers.data(), command.output.c_str(), command.errors.c_str(), command.output == command.errors);
    const int reason = errno;
    static_cast<void>(!::write(failure_pipe[1], &reason, sizeof reason));
    ::_exit(127);
  }
  const int fork_problem = errno;
  ::close(failure_pipe[1]);
  int reason = 0;
  const bool failed_to_start = child > 0 && ::read(failure_pipe[0], &reason, sizeof reason) == sizeof reason;
  ::close(failure_pipe[0]);
  if (child < 0) return fail(ErrorCode::kIo, command.arguments.front() + ": no process for it: " + std::strerror(fork_problem));

  int status = 0;
  rusage usage = {};
  while (::wait4(child, &status, 0, &usage) < 0) {
    if (errno != EINTR) return fail(ErrorCode::kIo, command.arguments.front() + ": cannot be waited for: " + std::strerror(errno));
  }
  if (failed_to_start) return fail(ErrorCode::kIo, command.arguments.front() + ": cannot be started: " + std::strerror(reason));

  ChildRun run;
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.processor_seconds = seconds_from(usage.ru_utime) + seconds_from(usage.ru_stime);
  run.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return run;
}

std::uint64_t smallest_peak_bytes() {
  const auto program = find_program("true");
  if (!program) return 0;
  const auto run = run_child({{program->string()}, {}, "/dev/null", "/dev/null"});
  return run ? run->peak_bytes : 0;
}

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* search = std::getenv("PATH");
  std::string_view rest = search == nullptr ? "" : search;
  while (!rest.empty()) {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const std::filesystem::path candidate = std::filesystem::path(rest.substr(0, colon)) / name;
    if (::access(candidate.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(candidate)) return candidate;
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  return std::nullopt;
}

Result<std::filesystem::path> program_beside(const std::string& name) {
  std::error_code problem;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", problem);
  const auto path = self.parent_path() / name;
  if (problem || ::access(path.c_str(), X_OK) != 0)
    return fail(ErrorCode::kIo, path.string() + ": not there; vtbench runs the " + name + " that lies beside it, build that too");
  return path;
}

std::string shell_text(const std::vector<std::string>& arguments) {
  std::string line;
  for (const std::string& argument : arguments) {
    if (!line.empty()) line += ' ';
    const bool plain = !argument.empty() && argument.find_first_not_of(
                                                "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                                "_-+=./,:@%") == std::string::npos;
    if (plain) {
      line += argument;
      continue;
    }
    line += '\'';
    for (const char c : argument) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace vt::bench
