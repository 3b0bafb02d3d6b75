// README.md as a newcomer follows it: every command in it is run in its order on a small demo scene, what it
// links to and names is there, and the C++ in it is text of a file that the build compiles. A command that is
// neither run nor listed here fails the test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/cli/program_run.h"
#include "tests/support/temp_folder.h"

namespace vt::test {
namespace {

const std::filesystem::path kProject = VT_SOURCE_DIR;

constexpr std::size_t kMostReadmeLines = 150;
constexpr std::size_t kMostReadmeColumns = 120;  // of prose; rows of tables and commands may be wider

// The scene is small here: what is said of 4096 texels is true of 512, which have two levels and several
// tiles.
constexpr const char* kSceneSize = "--size 512";

// Files that users bring along, and how the scene becomes each of them. A command that names one has it made
// first.
struct BroughtFile {
  std::string name;
  std::string recipe;
};
const std::vector<BroughtFile> kBroughtFiles = {
    {"ortho.tif", "cp scene/imagery.tif ortho.tif"},
    {"dem.tif", "cp scene/elevation.tif dem.tif"},
    {"cover.tif", "cp scene/materials.tif cover.tif"},
    {"classes.json", "cp scene/materials.json classes.json"},
    {"st_b10.tif", "cp scene/materials.tif st_b10.tif"},  // one band of codes; which codes does not matter
    {"earth.png", "vtinspect extract scene.vts --layer color -o earth.png"},
    {"west.tif", "vtinspect extract scene.vts --layer color --window 0,0,256,512 -o west.tif"},
    {"east.tif", "vtinspect extract scene.vts --layer color --window 256,0,256,512 -o east.tif"},
    {"patch.tif", "vtinspect extract scene.vts --layer color --window 128,128,256,256 -o patch.tif"},
    {"tiles/",
     "mkdir tiles && vtinspect extract scene.vts --layer color --window 0,0,256,256 -o tiles/north-west.tif && "
     "vtinspect extract scene.vts --layer color --window 256,0,256,256 -o tiles/north-east.tif"},
};

// Commands that install, compile or measure for minutes are not run. What they name must be there: the
// subcommand in `tools/dev help`, the preset in CMakePresets.json.
const std::vector<std::string> kCommandsNotRun = {"tools/dev demo",  "tools/dev test",    "tools/dev bench",
                                                  "tools/dev build", "tools/dev install", "tools/dev package",
                                                  "cmake --preset",  "cmake --build",     "cmake --install"};

const std::set<std::string> kProgramsThatRun = {"vtbuild", "vtinspect", "vtrender"};

struct ReadmeCommand {
  std::size_t line = 0;
  std::string text;
};

std::vector<std::string> lines_of_file(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> words_of_command(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// The texts between backticks of a line.
std::vector<std::string> code_spans(const std::string& line) {
  std::vector<std::string> spans;
  std::size_t start = line.find('`');
  while (start != std::string::npos) {
    const std::size_t end = line.find('`', start + 1);
    if (end == std::string::npos) break;
    spans.push_back(line.substr(start + 1, end - start - 1));
    start = line.find('`', end + 1);
  }
  return spans;
}

bool is_fence(const std::string& line) { return line.starts_with("```"); }
bool is_indented_code(const std::string& line) { return line.starts_with("    "); }

bool starts_like_command(const std::string& span) {
  const auto words = words_of_command(span);
  static const std::set<std::string> kFirstWords = {"vtbuild", "vtinspect", "vtrender", "vtbench", "tools/dev", "cmake", "ctest", "cpack"};
  return words.size() > 1 && kFirstWords.contains(words.front());
}

// All commands in their order: the lines of indented blocks, less their comments, and what stands between
// backticks and has arguments.
std::vector<ReadmeCommand> commands_of(const std::vector<std::string>& lines) {
  std::vector<ReadmeCommand> commands;
  bool is_fenced = false;
  bool goes_on = false;  // the line before ended with a backslash
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (is_fence(line)) is_fenced = !is_fenced;
    if (is_fenced || is_fence(line)) continue;
    if (!is_indented_code(line)) {
      for (const std::string& span : code_spans(line))
        if (starts_like_command(span)) commands.push_back({i + 1, span});
      continue;
    }
    std::string text = line.substr(4, line.find(" #") - 4);
    text.erase(0, text.find_first_not_of(' '));
    text.erase(text.find_last_not_of(' ') + 1);
    const bool will_go_on = text.ends_with('\\');
    if (will_go_on) text.pop_back();
    if (goes_on) {
      commands.back().text += text;
    } else if (!text.empty()) {
      commands.push_back({i + 1, text});
    }
    goes_on = will_go_on;
  }
  return commands;
}

bool is_listed_as_not_run(const std::string& command) {
  return std::ranges::any_of(kCommandsNotRun,
                             [&](const std::string& start) { return command == start || command.starts_with(start + " "); });
}

bool is_run(const std::string& command) { return kProgramsThatRun.contains(words_of_command(command).front()); }

// The command as the test runs it.
std::string small_command(const std::string& command) {
  static const std::regex kSize("--size [0-9]+");
  const auto words = words_of_command(command);
  if (words.size() == 2 && !words[1].starts_with("-") && words[0] != "vtrender") return command + " --help";  // prose that names it
  if (words[0] != "vtbuild" || words[1] != "sample") return command;
  return std::regex_search(command, kSize) ? std::regex_replace(command, kSize, kSceneSize) : command + " " + kSceneSize;
}

// What "-o NAME" says; empty when it is not said.
std::string named_output(const std::string& command) {
  const auto words = words_of_command(command);
  const auto flag = std::ranges::find(words, "-o");
  return flag == words.end() || flag + 1 == words.end() ? "" : *(flag + 1);
}

class Readme : public testing::Test {
 protected:
  Readme() : lines_(lines_of_file(kProject / "README.md")), commands_(commands_of(lines_)) {}

  Outcome shell(const std::string& command) const {
    const std::string programs = std::filesystem::path(VT_VTBUILD).parent_path().string();
    return run_program("/bin/sh", {"-c", "PATH='" + programs + "':\"$PATH\"; " + command}, folder_.path());
  }

  void bring_files_of(const std::string& command) {
    const auto words = words_of_command(command);
    for (const BroughtFile& file : kBroughtFiles) {
      if (std::ranges::find(words, file.name) == words.end() || !brought_.insert(file.name).second) continue;
      const Outcome made = shell(file.recipe);
      EXPECT_EQ(made.exit_code, 0) << file.recipe << "\n" << made.err;
    }
  }

  void run_and_check(const ReadmeCommand& command) {
    SCOPED_TRACE("README.md:" + std::to_string(command.line) + ": " + command.text);
    bring_files_of(command.text);
    const std::string output = named_output(command.text);
    const auto path = folder_ / output;
    const bool is_file = !output.empty() && std::filesystem::is_regular_file(path);
    if (is_file && path.extension() != ".vts") std::filesystem::remove(path);  // or it would pass for the command's
    const bool was_there = !output.empty() && std::filesystem::exists(path);

    const Outcome outcome = shell(small_command(command.text));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
    if (output.empty()) return;
    if (command.text.find("--dry-run") != std::string::npos) {
      EXPECT_EQ(std::filesystem::exists(path), was_there);
    } else {
      EXPECT_TRUE(std::filesystem::exists(path) && !std::filesystem::is_empty(path)) << "it leaves no " << output;
    }
  }

  TempFolder folder_;
  std::vector<std::string> lines_;
  std::vector<ReadmeCommand> commands_;
  std::set<std::string> brought_;
};

TEST_F(Readme, EveryCommandDoesWhatItSays) {
  int runs = 0;
  for (const ReadmeCommand& command : commands_) {
    if (is_listed_as_not_run(command.text)) continue;
    if (!is_run(command.text)) {
      ADD_FAILURE() << "README.md:" << command.line << ": neither run nor listed: " << command.text;
      continue;
    }
#ifndef VT_VTRENDER
    if (command.text.starts_with("vtrender")) continue;  // not built without EGL
#endif
    run_and_check(command);
    ++runs;
  }
  EXPECT_GT(runs, 20);
  for (const BroughtFile& file : kBroughtFiles) EXPECT_TRUE(brought_.contains(file.name)) << file.name << " is in no command any more";
}

TEST_F(Readme, WhatIsNotRunNamesWhatIsThere) {
  const Outcome help = run_program((kProject / "tools/dev").string(), {"help"}, folder_.path());
  ASSERT_EQ(help.exit_code, 0) << help.err;
  std::ifstream presets_file(kProject / "CMakePresets.json");
  const auto presets = nlohmann::json::parse(presets_file, nullptr, /*allow_exceptions=*/false);
  ASSERT_FALSE(presets.is_discarded());
  std::set<std::string> names;
  for (const auto& preset : presets["configurePresets"])
    if (!preset.value("hidden", false)) names.insert(preset["name"].get<std::string>());

  static const std::regex kPreset("(?:--preset |build/)([a-z-]+)");
  for (const ReadmeCommand& command : commands_) {
    if (!is_listed_as_not_run(command.text)) continue;
    SCOPED_TRACE("README.md:" + std::to_string(command.line) + ": " + command.text);
    const auto words = words_of_command(command.text);
    if (words[0] == "tools/dev") {
      EXPECT_THAT("\n" + help.out, testing::HasSubstr("\ntools/dev " + words[1] + " ")) << "no such subcommand";
      continue;
    }
    std::smatch found;
    ASSERT_TRUE(std::regex_search(command.text, found, kPreset)) << "it names no preset";
    EXPECT_TRUE(names.contains(found[1])) << "no such preset";
  }
  // The prose lists them all.
  for (const std::string& name : names) {
    const std::string span = "`" + name + "`";
    EXPECT_TRUE(std::ranges::any_of(lines_, [&](const std::string& line) { return line.find(span) != std::string::npos; })) << name;
  }
}

TEST_F(Readme, IsReadInOneSitting) {
  EXPECT_LE(lines_.size(), kMostReadmeLines);
  bool is_fenced = false;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const std::string& line = lines_[i];
    if (is_fence(line)) {
      is_fenced = !is_fenced;
      EXPECT_TRUE(!is_fenced || line == "```cpp") << "README.md:" << i + 1 << ": commands stand in indented blocks, and are run";
    }
    if (is_fenced || is_indented_code(line) || line.starts_with("|")) continue;
    EXPECT_LE(line.size(), kMostReadmeColumns) << "README.md:" << i + 1;
  }
}

// In it and in those of the folders.
TEST_F(Readme, LinksLeadSomewhere) {
  std::vector<std::filesystem::path> readmes = {kProject / "README.md"};
  for (const char* part : {"store", "builder", "runtime", "tools", "tests"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(kProject / part))
      if (entry.path().filename() == "README.md") readmes.push_back(entry.path());

  static const std::regex kLink(R"(\]\(([^)#]+)(#[^)]*)?\))");
  int links = 0;
  for (const auto& readme : readmes)
    for (const std::string& line : lines_of_file(readme))
      for (std::sregex_iterator link(line.begin(), line.end(), kLink); link != std::sregex_iterator(); ++link) {
        const std::string target = (*link)[1];
        if (target.find("://") != std::string::npos) continue;
        EXPECT_TRUE(std::filesystem::exists(readme.parent_path() / target)) << readme << " links to " << target;
        ++links;
      }
  EXPECT_GT(links, 10);
}

// Between backticks: paths from the project's root; in a row of the table of folders, what lies in the folder
// that the row links to.
TEST_F(Readme, FoldersAndFilesThatItNamesAreThere) {
  static const std::set<std::string> kTopFolders = {"store", "builder", "runtime", "tools", "tests", "schemas"};
  static const std::regex kRowOfFolder(R"(^\| \[`[^`]+`\]\(([^)]+)\) .*)");
  int names = 0;
  for (const std::string& line : lines_) {
    std::smatch row;
    const bool is_row = std::regex_match(line, row, kRowOfFolder);
    auto base = is_row ? kProject / row[1].str() : kProject;
    if (std::filesystem::is_regular_file(base)) base = base.parent_path();  // the folder's README
    for (const std::string& span : code_spans(line)) {
      if (span.find(' ') != std::string::npos) continue;
      const bool is_path = kTopFolders.contains(span.substr(0, span.find('/'))) && span.find('/') != std::string::npos;
      if (!is_path && !(is_row && span.ends_with('/'))) continue;
      EXPECT_TRUE(std::filesystem::exists((is_path ? kProject : base) / span)) << span;
      ++names;
    }
  }
  EXPECT_GT(names, 10);
}

TEST_F(Readme, ItsCodeIsTextThatIsCompiled) {
  std::vector<std::string> shown;
  bool is_fenced = false;
  for (const std::string& line : lines_) {
    if (is_fence(line)) {
      is_fenced = !is_fenced;
    } else if (is_fenced && !line.empty()) {
      shown.push_back(line);
    }
  }
  std::vector<std::string> compiled;
  bool is_marked = false;
  std::size_t indent = 0;
  for (const std::string& line : lines_of_file(kProject / "tests/runtime/readme_snippet.cpp")) {
    const std::size_t comment = line.find("// README: ");
    if (comment != std::string::npos) {
      is_marked = line.ends_with("from here");
      indent = comment;
    } else if (is_marked && !line.empty()) {
      compiled.push_back(line.substr(indent));
    }
  }
  EXPECT_GT(compiled.size(), 8U);
  EXPECT_EQ(shown, compiled);
}

TEST(ReadmeCommands, AreFoundWhereverTheyStand) {
  const auto commands = commands_of({
      "Say `vtbuild pack` or `--help`.",
      "",
      "    vtbuild layer a.tif \\",
      "      -o a.vts   # a comment",
      "    rm -rf everything",
      "```cpp",
      "    not_a_command();",
      "```",
  });
  ASSERT_EQ(commands.size(), 3U);
  EXPECT_EQ(commands[0].text, "vtbuild pack");
  EXPECT_EQ(small_command(commands[0].text), "vtbuild pack --help");
  EXPECT_EQ(commands[1].text, "vtbuild layer a.tif -o a.vts");
  EXPECT_EQ(commands[1].line, 3U);
  EXPECT_EQ(named_output(commands[1].text), "a.vts");
  EXPECT_EQ(commands[2].text, "rm -rf everything");
  EXPECT_FALSE(is_run(commands[2].text) || is_listed_as_not_run(commands[2].text));
  EXPECT_EQ(small_command("vtbuild sample -o s --size 4096"), "vtbuild sample -o s --size 512");
  EXPECT_EQ(small_command("vtbuild sample -o s"), "vtbuild sample -o s --size 512");
}

}  // namespace
}  // namespace vt::test
