// A library does not know whether it is asked on a command line or in a scene file: its messages name
// settings, `bands`, and not flags or the commands of programs. Programs put their flags in
// (tools/cli/setting_names.h).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

namespace vt::test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The text between the quotes of every string literal, escapes as they are written. Comments and characters
// are passed over.
std::vector<std::string> literals_in(const std::string& code) {
  std::vector<std::string> literals;
  for (std::size_t at = 0; at < code.size();) {
    const auto ends_with = [&](const std::string& end) { return std::min(code.find(end, at), code.size() - end.size()) + end.size(); };
    if (code.compare(at, 2, "//") == 0) {
      at = ends_with("\n");
    } else if (code.compare(at, 2, "/*") == 0) {
      at = ends_with("*/");
    } else if (code.compare(at, 2, "R\"") == 0) {
      const std::size_t open = code.find('(', at);
      const std::string end = ")" + code.substr(at + 2, open - at - 2) + "\"";
      const std::size_t from = open + 1;
      at = ends_with(end);
      literals.push_back(code.substr(from, at - end.size() - from));
    } else if (code[at] == '"' || (code[at] == '\'' && (at == 0 || std::isalnum(static_cast<unsigned char>(code[at - 1])) == 0))) {
      const char quote = code[at];
      const std::size_t from = ++at;
      while (at < code.size() && code[at] != quote) at += code[at] == '\\' ? 2 : 1;
      if (quote == '"') literals.push_back(code.substr(from, at - from));
      ++at;
    } else {
      ++at;
    }
  }
  return literals;
}

// The flag or the command that a message names; empty when there is none. Flags of GDAL's programs are
// GDAL's.
std::string named_in(const std::string& literal) {
  static const std::regex kFlag("(?:^|[^-`\\w])(--[a-z][a-z-]*)");
  static const std::regex kCommand("(vtbuild|vtinspect|vtrender|vtbench) [a-z]+");
  std::smatch found;
  if (std::regex_search(literal, found, kCommand)) return found[0];
  if (std::regex_search(literal, found, kFlag) && literal.find("gdal_translate --config") == std::string::npos) return found[1];
  return "";
}

TEST(LibraryMessages, NameSettingsAndNoFlags) {
  int seen = 0;
  for (const char* part : {"store", "builder", "runtime"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(VT_SOURCE_DIR) / part)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
      for (const std::string& literal : literals_in(text_of(entry.path()))) {
        ++seen;
        EXPECT_EQ(named_in(literal), "") << entry.path() << ": \"" << literal << "\"";
      }
    }
  EXPECT_GT(seen, 2000);
}

TEST(LibraryMessages, AreFoundInCode) {
  const std::string code = "// \"comment --a\"\nf('\"', \"one \\\" two\"); /* \"--b\" */ int i = 1'000; R\"x(raw \"--c\")x\" \"--d\"";
  EXPECT_EQ(literals_in(code), (std::vector<std::string>{"one \\\" two", "raw \"--c\"", "--d"}));
  EXPECT_EQ(named_in("choose with --bands, please"), "--bands");
  EXPECT_EQ(named_in("--crs EPSG:4326"), "--crs");
  EXPECT_EQ(named_in("run `vtbuild remove` first"), "vtbuild remove");
  for (const char* fine : {"choose with `bands`", "gdal_translate --config A B", "a - b -- c", "-----BEGIN PGP", "vtbuild "})
    EXPECT_EQ(named_in(fine), "") << fine;
}

}  // namespace
}  // namespace vt::test
