#include "tests/cli/program_run.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "builder/text/json_schema.h"
#include "tests/support/temp_folder.h"

namespace vt::test {

namespace {

std::string contents_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

[[noreturn]] void throw_errno(const char* act) { throw std::system_error(errno, std::generic_category(), act); }

int open_output(const std::filesystem::path& path, StandardOutput output) {
  if (output == StandardOutput::kFullDisk) return ::open("/dev/full", O_WRONLY);
  if (output == StandardOutput::kKept) return ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw_errno("pipe");
  ::close(ends[0]);  // nobody will ever read
  return ends[1];
}

}  // namespace

Outcome run_program(const std::string& program, const std::vector<std::string>& arguments, const std::filesystem::path& directory,
                    StandardOutput output) {
  // Outside `directory`, which the test may want to find as the program left it.
  const TempFolder said;
  const int in = ::open("/dev/null", O_RDONLY);
  const int out = open_output(said / "out", output);
  const int err = open_output(said / "err", StandardOutput::kKept);
  if (in < 0 || out < 0 || err < 0) throw_errno("open");

  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  const pid_t child = ::fork();
  if (child < 0) throw_errno("fork");
  if (child == 0) {
    if (::chdir(directory.c_str()) != 0 || ::dup2(in, STDIN_FILENO) < 0 || ::dup2(out, STDOUT_FILENO) < 0 ||
        ::dup2(err, STDERR_FILENO) < 0) {
      ::_exit(126);
    }
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  ::close(in);
  ::close(out);
  ::close(err);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw_errno("waitpid");
  }
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = contents_of(said / "out");
  outcome.err = contents_of(said / "err");
  return outcome;
}

std::string schema_complaints(const std::string& schema_name, const nlohmann::json& document) {
  const auto file = std::filesystem::path(VT_SCHEMAS) / (schema_name + ".schema.json");
  const nlohmann::json schema_text = nlohmann::json::parse(contents_of(file));
  const auto found = text::schema_complaints(document, schema_text);
  if (!found) return found.error().message;
  std::string complaints;
  for (const text::SchemaComplaint& complaint : *found) {
    for (const std::string& part : complaint.place) complaints += part;
    complaints += ": " + complaint.description + "\n";
  }
  return complaints;
}

}  // namespace vt::test
