#include "store/format/file_beside.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>

#include "store/format/layout.h"
#include "store/format/snapshot.h"
#include "store/io/folder.h"
#include "store/io/hex.h"
#include "store/io/uuid.h"

namespace vt::store {
namespace {

constexpr std::string_view kMark = ".new-";
constexpr int kMostAttempts = 100;

// NAME.new-0123456789abcdef, or what older programs wrote: NAME.new- and a decimal number.
bool is_name_beside(std::string_view name, std::string_view target) {
  if (!name.starts_with(target) || !name.substr(target.size()).starts_with(kMark)) return false;
  const std::string_view digits = name.substr(target.size() + kMark.size());
  const auto all = [&](std::string_view allowed) { return digits.find_first_not_of(allowed) == std::string_view::npos; };
  return (digits.size() == kRandomDigits && all(kHexDigits)) || (!digits.empty() && digits.size() <= 10 && all("0123456789"));
}

bool is_of_older_programs(std::string_view name) { return name.size() - name.rfind(kMark) - kMark.size() != kRandomDigits; }

// A file with a decimal number in its name may be somebody's own; one that is no whole store is what a writer
// left.
bool holds_a_whole_store(const File& file) {
  const auto head = read_head(file);
  return head && choose_superblock(head->bytes, head->file_bytes);
}

// The lock is free when no writer lives. What becomes of the file meanwhile is its writer's affair, who looks
// at its name once he has the lock.
bool remove_if_left_behind(const std::filesystem::path& path) {
  auto file = File::open(path, File::Mode::kRead);
  if (!file) return false;
  const auto locked = file->try_lock();
  if (!locked || !*locked) return false;
  if (is_of_older_programs(path.filename().native()) && holds_a_whole_store(*file)) return false;
  std::error_code problem;
  return std::filesystem::remove(path, problem) && !problem;
}

}  // namespace

Result<File> create_beside(const std::filesystem::path& target, const File* replaced) {
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    std::filesystem::path path = target;
    path += std::string(kMark) + random_digits();
    auto file = File::open(path, replaced == nullptr ? File::Mode::kCreate : File::Mode::kCreatePrivate);
    if (!file && file.error().code == ErrorCode::kExists) continue;
    if (!file) return file;
    // Before it was locked somebody may have taken the file for what a killed writer left.
    VT_ASSIGN(const bool is_locked, file->try_lock());
    VT_ASSIGN(const bool is_there, file->still_named());
    if (!is_locked || !is_there) continue;
    if (replaced == nullptr) return file;
    const auto given = file->take_owner_and_mode_of(*replaced);
    if (given) return file;
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return tl::unexpected(given.error());
  }
  return fail(ErrorCode::kIo, target.string() + ": no file can be made beside it; another program removes what is new there");
}

Result<void> take_name(File& file, const std::filesystem::path& target, bool sync) {
  VT_CHECK(rename_into_place(file.path(), target, sync));
  file.set_name(target);
  return {};
}

Result<void> take_place(File& file, const std::filesystem::path& target, const File& replaced, bool sync) {
  VT_CHECK(replace_file(file.path(), target, replaced, sync));
  file.set_name(target);
  return {};
}

std::vector<std::filesystem::path> remove_leftovers(const std::filesystem::path& target) {
  const std::filesystem::path folder = folder_of(target);
  const std::string name = target.filename().native();
  std::vector<std::filesystem::path> removed;
  std::error_code problem;
  for (std::filesystem::directory_iterator entry(folder, problem); !problem && entry != std::filesystem::directory_iterator();
       entry.increment(problem)) {
    std::error_code unknown;
    const std::filesystem::path path = target.has_parent_path() ? entry->path() : entry->path().filename();
    if (!is_name_beside(path.filename().native(), name) || !std::filesystem::is_regular_file(entry->symlink_status(unknown))) continue;
    if (remove_if_left_behind(path)) removed.push_back(path);
  }
  std::ranges::sort(removed);
  return removed;
}

}  // namespace vt::store
