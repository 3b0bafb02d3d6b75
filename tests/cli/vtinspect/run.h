// vtinspect in a directory that holds one sample store.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli/program_run.h"
#include "tests/cli/sample_store.h"
#include "tests/support/temp_folder.h"

namespace vt::test {

class VtinspectTest : public testing::Test {
 protected:
  [[nodiscard]] Outcome run(const std::vector<std::string>& arguments, StandardOutput output = StandardOutput::kKept) const {
    return run_program(VT_VTINSPECT, arguments, directory_.path(), output);
  }
  // Runs with --json, wants success (or `exit_code`), and holds the output against the schema.
  [[nodiscard]] nlohmann::json run_json(const std::string& schema, std::vector<std::string> arguments, int exit_code = 0) const {
    arguments.emplace_back("--json");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out, nullptr, /*allow_exceptions=*/false);
    EXPECT_EQ(json.is_discarded() ? "not JSON" : schema_complaints(schema, json), "") << outcome.out;
    return json;
  }
  void write_file(const std::string& name, const std::string& text) const { std::ofstream(directory_ / name, std::ios::binary) << text; }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(directory_.path())) names.push_back(entry.path().filename().string());
    return names;
  }

  TempFolder directory_;
};

}  // namespace vt::test
