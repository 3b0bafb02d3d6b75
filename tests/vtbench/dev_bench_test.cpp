// `tools/dev bench` without running it: what it would run, and that the programs know those options.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/support/temp_folder.h"
#include "tools/vtbench/measure/machine.h"
#include "tools/vtbench/peers/child_process.h"

namespace vt::bench {
namespace {

class DevBench : public ::testing::Test {
 protected:
  int run(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program);
    const auto child = run_child({arguments, {}, folder_ / "out", folder_ / "err"});
    EXPECT_TRUE(child.has_value()) << (child ? "" : child.error().message);
    return child ? child->exit_code : -1;
  }
  int bench(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "bench");
    return run(VT_DEV, std::move(arguments));
  }
  [[nodiscard]] std::string text(const std::string& name) const { return read_text_file(folder_ / name).value_or(""); }
  [[nodiscard]] std::string results() const { return (folder_ / "results").string(); }

  test::TempFolder folder_;
};

const std::set<std::string>& parts() {
  static const std::set<std::string> names = {"build", "dem",    "channels", "scoreboard", "sources",
                                              "sizes", "mosaic", "accuracy", "lookup",     "frame"};
  return names;
}

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> out;
  for (std::string word; in >> word;) out.push_back(word);
  return out;
}

TEST_F(DevBench, HelpNamesEveryPartAndSaysHowLongItTakes) {
  ASSERT_EQ(bench({"--help"}), 0) << text("err");
  for (const std::string& part : parts()) EXPECT_NE(text("out").find("\n  " + part + " "), std::string::npos) << part;
  EXPECT_NE(text("out").find("minutes"), std::string::npos);
}

TEST_F(DevBench, DryRunWritesNothingAndEveryCommandHasOptionsThatVtbenchKnows) {
  for (const char* mode : {"--runs=3", "--full", "--quick"}) {
    std::vector<std::string> arguments = {results(), "--dry-run", mode};
    if (std::string(mode) == "--runs=3") arguments.back() = "--runs", arguments.emplace_back("3");
    ASSERT_EQ(bench(arguments), 0) << text("err");
    EXPECT_FALSE(std::filesystem::exists(results()));
    std::set<std::string> seen;
    std::istringstream lines(text("out"));
    for (std::string line; std::getline(lines, line);) {
      const std::vector<std::string> command = words(line);
      ASSERT_GE(command.size(), 2U) << line;
      if (!command[0].ends_with("/vtbench")) continue;
      const std::size_t csv = line.find(results() + "/");
      ASSERT_NE(csv, std::string::npos);
      for (const std::string& part : parts())
        if (line.find(results() + "/" + part + ".csv") != std::string::npos) seen.insert(part);
      ASSERT_EQ(run(VT_VTBENCH, {command[1], "--help"}), 0);
      for (const std::string& word : command) {
        if (word.starts_with("--")) {
          EXPECT_NE(text("out").find("  " + word + " "), std::string::npos) << line;
        }
      }
    }
    EXPECT_EQ(seen, parts()) << mode;
  }
}

TEST_F(DevBench, RunsOnlyThePartsThatAreAskedFor) {
  ASSERT_EQ(bench({results(), "--dry-run", "--part", "mosaic,lookup"}), 0) << text("err");
  EXPECT_NE(text("out").find("vtbench mosaic"), std::string::npos);
  EXPECT_NE(text("out").find("vtbench lookup"), std::string::npos);
  EXPECT_EQ(text("out").find("vtbench build"), std::string::npos);
}

TEST_F(DevBench, WrongOptionsEndBeforeAnythingIsDone) {
  EXPECT_EQ(bench({results(), "--part", "build,speed"}), 1);
  EXPECT_NE(text("err").find("'speed'"), std::string::npos);
  EXPECT_EQ(bench({results(), "--full", "--quick"}), 1);
  EXPECT_EQ(bench({results(), "--fast"}), 1);
  EXPECT_NE(text("err").find("--fast"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(results()));
}

}  // namespace
}  // namespace vt::bench
