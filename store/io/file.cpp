#include "store/io/file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "store/io/folder.h"

namespace vt::store {
namespace {

std::string reason(int error_number) {
  std::string text = std::generic_category().message(error_number);
  if (error_number == ENOSPC || error_number == EDQUOT) text += "; free some space and run again, what was committed is safe";
  if (error_number == EFBIG) text += "; raise the limit on the size of files (ulimit -f) and run again, what was committed is safe";
  return text;
}

tl::unexpected<Error> cannot_rename(const std::filesystem::path& from, const std::filesystem::path& to, int error_number) {
  return fail(ErrorCode::kIo, to.string() + ": cannot rename " + from.string() + " to it: " + reason(error_number));
}

// What is printed after the program's caller has closed a standard stream goes to whatever file has got its
// number. Never to a store.
int above_standard_streams(int fd) {
  if (fd < 0 || fd > STDERR_FILENO) return fd;
  const int moved = ::fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int error_number = errno;
  ::close(fd);
  errno = error_number;
  return moved;
}

}  // namespace

Result<File> File::open(const std::filesystem::path& path, Mode mode) {
  const bool creates = mode == Mode::kCreate || mode == Mode::kCreatePrivate;
  // O_NONBLOCK: a pipe that nobody writes to must be refused, not waited for; it changes nothing about files.
  const int flags = O_CLOEXEC | O_NONBLOCK | O_NOCTTY | (mode == Mode::kRead ? O_RDONLY : O_RDWR) | (creates ? O_CREAT | O_EXCL : 0);
  File file;
  file.path_ = path;
  file.fd_ = above_standard_streams(::open(path.c_str(), flags, mode == Mode::kCreatePrivate ? 0600 : 0666));
  if (file.fd_ < 0) {
    const int error_number = errno;
    return fail(error_number == EEXIST ? ErrorCode::kExists : ErrorCode::kIo,
                path.string() + (creates ? ": cannot create: " : ": cannot open: ") + reason(error_number));
  }
  VT_CHECK(file.size());  // says what is no regular file
  return file;
}

File::File(File&& other) noexcept : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)), hook_(other.hook_) {}

File& File::operator=(File&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(path_, other.path_);
  std::swap(hook_, other.hook_);
  return *this;
}

File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

tl::unexpected<Error> File::refuse(const char* act, int error_number) const {
  return fail(ErrorCode::kIo, path_.string() + ": cannot " + act + ": " + reason(error_number));
}

int File::ask_hook(FileOperation::Kind kind, std::uint64_t offset, std::span<const std::byte> bytes) const {
  return hook_ != nullptr && *hook_ ? (*hook_)({.kind = kind, .offset = offset, .bytes = bytes}) : 0;
}

Result<std::uint64_t> File::size() const {
  struct stat info = {};
  if (::fstat(fd_, &info) != 0) return refuse("stat", errno);
  if (!S_ISREG(info.st_mode)) return fail(ErrorCode::kIo, path_.string() + ": not a regular file");
  return static_cast<std::uint64_t>(info.st_size);
}

Result<void> File::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  while (!out.empty()) {
    const ssize_t got = ::pread(fd_, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return refuse("read", errno);
    if (got == 0)
      return fail(ErrorCode::kIo, path_.string() + ": ends at offset " + std::to_string(offset) +
                                      ", where more was a moment ago; another program cuts it off or overwrites it");
    offset += static_cast<std::uint64_t>(got);
    out = out.subspan(static_cast<std::size_t>(got));
  }
  return {};
}

Result<void> File::write_at(std::uint64_t offset, std::span<const std::byte> first, std::span<const std::byte> second,
                            std::size_t alignment) {
  static constexpr std::array<std::byte, 64> kZeros = {};
  assert(alignment <= kZeros.size());
  const std::size_t over = (first.size() + second.size()) % alignment;
  std::array<std::span<const std::byte>, 3> parts = {first, second, std::span(kZeros).first(over == 0 ? 0 : alignment - over)};

  if (hook_ != nullptr && *hook_) {
    std::vector<std::byte> whole;
    for (const auto part : parts) whole.insert(whole.end(), part.begin(), part.end());
    if (const int refused = ask_hook(FileOperation::Kind::kWrite, offset, whole); refused != 0) return refuse("write", refused);
  }

  std::size_t part = 0;
  while (part < parts.size()) {
    std::array<iovec, 3> pieces;
    int count = 0;
    for (std::size_t i = part; i < parts.size(); ++i)
      pieces[static_cast<std::size_t>(count++)] = {.iov_base = const_cast<std::byte*>(parts[i].data()), .iov_len = parts[i].size()};
    const ssize_t written = ::pwritev(fd_, pieces.data(), count, static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return refuse("write", errno);
    offset += static_cast<std::uint64_t>(written);
    // A short write goes on where it stopped.
    auto left = static_cast<std::size_t>(written);
    while (part < parts.size() && left >= parts[part].size()) left -= parts[part++].size();
    if (part < parts.size()) parts[part] = parts[part].subspan(left);
  }
  return {};
}

Result<void> File::sync() {
  if (const int refused = ask_hook(FileOperation::Kind::kSync, 0, {}); refused != 0) return refuse("sync", refused);
  while (::fdatasync(fd_) != 0)
    if (errno != EINTR) return refuse("sync", errno);
  return {};
}

void File::start_writeback(std::uint64_t offset, std::uint64_t bytes) const {
  // What goes wrong here goes wrong again, and is reported, in sync().
  [[maybe_unused]] const int ignored = ::sync_file_range(fd_, static_cast<off_t>(offset), static_cast<off_t>(bytes), SYNC_FILE_RANGE_WRITE);
}

Result<void> File::truncate(std::uint64_t bytes) {
  if (const int refused = ask_hook(FileOperation::Kind::kTruncate, bytes, {}); refused != 0) return refuse("truncate", refused);
  while (::ftruncate(fd_, static_cast<off_t>(bytes)) != 0)
    if (errno != EINTR) return refuse("truncate", errno);
  return {};
}

Result<bool> File::try_lock() {
  while (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno != EINTR) return refuse("lock", errno);
  }
  return true;
}

Result<bool> File::is_at(const std::filesystem::path& path) const {
  struct stat opened = {};
  struct stat named = {};
  if (::fstat(fd_, &opened) != 0) return refuse("stat", errno);
  if (::stat(path.c_str(), &named) != 0) {
    if (errno == ENOENT) return false;
    return fail(ErrorCode::kIo, path.string() + ": cannot stat: " + reason(errno));
  }
  return opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

void File::remove_own_name() const {
  if (const auto is_own = still_named(); is_own && *is_own) ::unlink(path_.c_str());
}

Result<void> File::take_owner_and_mode_of(const File& other) {
  struct stat own = {};
  struct stat wanted = {};
  if (::fstat(fd_, &own) != 0) return refuse("stat", errno);
  if (::fstat(other.fd_, &wanted) != 0) return other.refuse("stat", errno);
  const bool is_other_owner = own.st_uid != wanted.st_uid || own.st_gid != wanted.st_gid;
  if (is_other_owner && ::fchown(fd_, wanted.st_uid, wanted.st_gid) != 0)
    return fail(ErrorCode::kIo, other.path_.string() + ": belongs to user " + std::to_string(wanted.st_uid) + " and group " +
                                    std::to_string(wanted.st_gid) + ", to whom a new file in its place cannot be given: " + reason(errno) +
                                    "; do this as that user, or write to another name");
  if (::fchmod(fd_, wanted.st_mode & 07777) != 0) return refuse("set the permissions of", errno);
  return {};
}

Result<void> File::close() {
  const int fd = std::exchange(fd_, -1);
  // On Linux the descriptor is gone even when close reports EINTR.
  if (fd >= 0 && ::close(fd) != 0 && errno != EINTR) return refuse("close", errno);
  return {};
}

Result<void> rename_into_place(const std::filesystem::path& from, const std::filesystem::path& to, bool sync) {
  int failed = ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0 ? 0 : errno;
  if (failed == EINVAL || failed == ENOSYS) {
    // This file system cannot rename without replacing; a link refuses an existing name just as well.
    failed = ::link(from.c_str(), to.c_str()) == 0 ? 0 : errno;
    if (failed == 0) ::unlink(from.c_str());
  }
  if (failed == EEXIST) return fail(ErrorCode::kExists, to.string() + ": is there already; remove it or choose another name");
  if (failed != 0) return cannot_rename(from, to, failed);
  return sync ? sync_folder_of(to) : Result<void>{};
}

Result<void> replace_file(const std::filesystem::path& from, const std::filesystem::path& to, const File& replaced, bool sync) {
  const auto exchange = [&] { return ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0 ? 0 : errno; };
  const auto taken = [&] {
    return fail(ErrorCode::kExists, to.string() + ": was replaced or removed by another program meanwhile; nothing was changed, run again");
  };
  int failed = exchange();
  if (failed == 0) {
    // Only now it is certain what had the name.
    const Result<bool> is_right = replaced.is_at(from);
    if (!is_right || !*is_right) {
      if (failed = exchange(); failed != 0) return cannot_rename(from, to, failed);
      return is_right ? taken() : tl::unexpected(is_right.error());
    }
    if (::unlink(from.c_str()) != 0)
      return fail(ErrorCode::kIo, from.string() + ": the file that was replaced cannot be removed: " + reason(errno));
  } else if (failed == EINVAL || failed == ENOSYS) {
    // This file system cannot exchange two names; what happens between the next two calls goes unseen.
    VT_ASSIGN(const bool is_right, replaced.is_at(to));
    if (!is_right) return taken();
    if (::rename(from.c_str(), to.c_str()) != 0) return cannot_rename(from, to, errno);
  } else if (failed == ENOENT) {
    return taken();
  } else {
    return cannot_rename(from, to, failed);
  }
  return sync ? sync_folder_of(to) : Result<void>{};
}

}  // namespace vt::store
