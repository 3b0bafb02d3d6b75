// Runs a program in an empty directory and keeps what it says, so that tests can hold exit code, output and
// errors against what users are promised.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace vt::test {

struct Outcome {
  int exit_code = -1;  // 128 + n when signal n ended the program
  std::string out;
  std::string err;
};

enum class StandardOutput { kKept, kClosedPipe, kFullDisk };

// Runs `program` with `arguments` in `directory`; standard input is empty.
[[nodiscard]] Outcome run_program(const std::string& program, const std::vector<std::string>& arguments,
                                  const std::filesystem::path& directory, StandardOutput output = StandardOutput::kKept);

// What is wrong with `document` by the schema file of that name in schemas/; "" when nothing is.
[[nodiscard]] std::string schema_complaints(const std::string& schema_name, const nlohmann::json& document);

}  // namespace vt::test
