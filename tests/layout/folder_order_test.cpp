// The house as it is built: includes point down the floors that folder_order.txt names, no folder grows past
// what one can look over, and each says what it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace vt::test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = VT_SOURCE_DIR;
const fs::path kOrder = kRoot / "tests/layout/folder_order.txt";
const std::vector<std::string> kParts = {"store", "runtime", "builder", "tools"};

// Sources and tables that lie in one folder, apart from what every folder has.
constexpr int kMostFiles = 27;

struct Place {
  std::size_t floor = 0;
  std::size_t column = 0;  // of those that stand apart on the floor
  std::string path;
};

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// "NAME path path | path": the paths of a floor, by column.
std::vector<Place> places_of(std::istream& order) {
  std::vector<Place> places;
  std::size_t floor = 0;
  for (std::string line; std::getline(order, line);) {
    const auto words = words_of(line.substr(0, line.find('#')));
    if (words.empty()) continue;
    std::size_t column = 0;
    for (const std::string& word : words) {
      if (word == "|") {
        ++column;
      } else {
        places.push_back({floor, column, word});
      }
    }
    ++floor;
  }
  return places;
}

// The longest path that is `file` without its suffix, or a folder around it.
std::optional<Place> place_of(const std::vector<Place>& places, const std::string& file) {
  const std::string stem = file.substr(0, file.rfind('.'));
  std::optional<Place> best;
  for (const Place& place : places)
    if ((place.path == stem || file.starts_with(place.path + "/")) && (!best || place.path.size() > best->path.size())) best = place;
  return best;
}

// Empty when `file` may include `included`, else what is wrong.
std::string arrow_fault(const std::vector<Place>& places, const std::string& file, const std::string& included) {
  const auto from = place_of(places, file);
  const auto to = place_of(places, included);
  if (!from) return file + " stands on no floor";
  if (!to) return included + " stands on no floor";
  if (to->floor > from->floor) return file + " -> " + included + " points up";
  if (to->floor == from->floor && to->column != from->column) return file + " -> " + included + " points to a neighbour";
  return "";
}

bool is_source(const fs::path& path) { return path.extension() == ".h" || path.extension() == ".cpp"; }

// Files of the project, from its root, with slashes.
std::vector<std::string> files_below(const std::string& part) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / part))
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), kRoot).generic_string());
  std::ranges::sort(files);
  return files;
}

std::vector<std::string> includes_of(const std::string& file) {
  std::vector<std::string> includes;
  std::ifstream stream(kRoot / file);
  const std::string start = "#include \"";
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(start)) includes.push_back(line.substr(start.size(), line.find('"', start.size()) - start.size()));
  return includes;
}

TEST(FolderOrder, IncludesPointDownTheFloors) {
  std::ifstream order(kOrder);
  const auto places = places_of(order);
  int arrows = 0;
  for (const std::string& part : kParts)
    for (const std::string& file : files_below(part)) {
      if (!is_source(file)) continue;
      EXPECT_TRUE(place_of(places, file)) << file << " stands on no floor of folder_order.txt";
      for (const std::string& included : includes_of(file)) {
        ++arrows;
        EXPECT_EQ(arrow_fault(places, file, included), "");
      }
    }
  EXPECT_GT(arrows, 1000);
}

TEST(FolderOrder, ArrowsUpAndToNeighboursAreFound) {
  std::istringstream order("a/base a/other\na/left | a/right  # apart\na\n");
  const auto places = places_of(order);
  EXPECT_EQ(arrow_fault(places, "a/top.cpp", "a/left/x.h"), "");
  EXPECT_EQ(arrow_fault(places, "a/left/x.cpp", "a/left/y.h"), "");
  EXPECT_EQ(arrow_fault(places, "a/base.h", "a/other.h"), "");
  EXPECT_EQ(arrow_fault(places, "a/base.h", "a/left/x.h"), "a/base.h -> a/left/x.h points up");
  EXPECT_EQ(arrow_fault(places, "a/left/x.cpp", "a/top.h"), "a/left/x.cpp -> a/top.h points up");
  EXPECT_EQ(arrow_fault(places, "a/left/x.cpp", "a/right/y.h"), "a/left/x.cpp -> a/right/y.h points to a neighbour");
  EXPECT_EQ(arrow_fault(places, "b/x.cpp", "a/top.h"), "b/x.cpp stands on no floor");
}

TEST(FolderOrder, EveryLineNamesSomethingThatIsThere) {
  std::ifstream order(kOrder);
  for (const Place& place : places_of(order)) {
    const fs::path path = kRoot / place.path;
    EXPECT_TRUE(fs::is_directory(path) || fs::exists(path.string() + ".h") || fs::exists(path.string() + ".cpp")) << place.path;
  }
}

// Folders with files in them, and how many: sources and tables, apart from what every folder has.
std::map<std::string, int> folder_sizes() {
  std::map<std::string, int> sizes;
  for (const char* part : {"store", "runtime", "builder", "tools", "tests"})
    for (const std::string& file : files_below(part)) {
      const fs::path path = file;
      if (path.filename() != "CMakeLists.txt" && path.filename() != "README.md") ++sizes[path.parent_path().generic_string()];
    }
  return sizes;
}

std::string text_of(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(FolderOrder, FoldersAreSmall) {
  for (const auto& [folder, files] : folder_sizes()) EXPECT_LE(files, kMostFiles) << folder;
}

// By a README.md of its own, or by a word about `NAME/` in that of the folder around it.
TEST(FolderOrder, FoldersSayWhatTheyAre) {
  for (const auto& [folder, files] : folder_sizes()) {
    const fs::path path = folder;
    const bool is_named =
        text_of(kRoot / path.parent_path() / "README.md").find("`" + path.filename().string() + "/`") != std::string::npos;
    EXPECT_TRUE(fs::exists(kRoot / path / "README.md") || is_named) << folder;
  }
}

TEST(FolderOrder, ReadmesAreNoLongerThanAScreen) {
  for (const auto& [folder, files] : folder_sizes()) {
    if (folder == "tools/vtbench") continue;  // what was measured, and how
    const std::string text = text_of(kRoot / folder / "README.md");
    EXPECT_LE(std::ranges::count(text, '\n'), 60) << folder;
  }
}

}  // namespace
}  // namespace vt::test
