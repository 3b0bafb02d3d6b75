#include "store/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <string>
#include <system_error>
#include <utility>

#include "store/io/folder.h"
#include "store/io/uuid.h"

namespace vt::store {
namespace {

// Libraries write headers and checksums of a few bytes; the system gets them together.
constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr int kMostLinks = 40;  // as many as Linux follows
constexpr mode_t kPermissions = 0777;

std::string failure_text(int error_number) {
  const std::string text = std::generic_category().message(error_number);
  if (error_number == ENOSPC || error_number == EDQUOT) return text + "; free some space or write elsewhere";
  if (error_number == EFBIG) return text + "; raise the limit on the size of files (ulimit -f)";
  return text;
}

// In a folder like /tmp anybody may have put a link to somewhere else: there a user's own links count, and
// those of the folder's owner. (The rule of Linux's fs.protected_symlinks, wherever that is switched off.)
bool is_planted(const struct stat& link, const std::filesystem::path& folder) {
  struct stat around = {};
  if (::stat(folder.c_str(), &around) != 0) return true;
  const bool is_shared = (around.st_mode & S_ISVTX) != 0 && (around.st_mode & S_IWOTH) != 0;
  return is_shared && link.st_uid != ::geteuid() && link.st_uid != around.st_uid;
}

// One link of a chain, looked at and read while it is held, so that nobody can exchange it in between. "" in
// `next`: the path is no link.
int read_link(const std::filesystem::path& path, std::filesystem::path& next) {
  next.clear();
  const int fd = ::open(path.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC);
  if (fd < 0) return errno == ENOENT ? 0 : errno;
  struct stat link = {};
  std::array<char, PATH_MAX> text{};
  int failed = ::fstat(fd, &link) == 0 ? 0 : errno;
  if (failed == 0 && S_ISLNK(link.st_mode)) {
    const ssize_t length = ::readlinkat(fd, "", text.data(), text.size());
    if (length < 0) failed = errno;
    if (length >= 0 && is_planted(link, folder_of(path))) failed = EACCES;
    if (failed == 0) next = std::string(text.data(), static_cast<std::size_t>(length));
  }
  ::close(fd);
  return failed;
}

// Where a chain of symbolic links ends, whether something is there or not. Returns an errno, or 0.
int follow_links(std::filesystem::path path, std::filesystem::path& end) {
  for (int link = 0; link < kMostLinks; ++link) {
    std::filesystem::path next;
    if (const int failed = read_link(path, next); failed != 0) return failed;
    if (next.empty()) {
      end = path;
      return 0;
    }
    path = next.is_absolute() ? next : folder_of(path) / next;
  }
  return ELOOP;
}

// ".vt-0123456789abcdef.partial": as long for every target, so that no target's name is too long for it.
std::string random_name() { return ".vt-" + random_digits() + ".partial"; }

// A file without a name gets one through the name that /proc has for its descriptor.
std::string proc_name(int fd) { return "/proc/self/fd/" + std::to_string(fd); }

int sync_descriptor(int fd) {
  while (::fsync(fd) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

}  // namespace

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) { return create(target, Options{}); }

Result<OutputFile> OutputFile::create(const std::filesystem::path& target, const Options& options) {
  OutputFile file;
  file.path_ = target;
  file.sync_ = options.sync;
  struct stat there = {};
  const bool is_there = ::stat(target.c_str(), &there) == 0;
  if (!is_there && errno != ENOENT) return file.refuse("create", errno);
  if (is_there && S_ISDIR(there.st_mode)) return file.refuse("create", EISDIR);
  if (is_there && !S_ISREG(there.st_mode)) {
    VT_CHECK(file.open_stream());
    return file;
  }
  if (const int failed = follow_links(target, file.target_); failed != 0) return file.refuse("create", failed);
  VT_CHECK(file.open_beside(options));
  return file;
}

Result<void> OutputFile::open_stream() {
  is_stream_ = true;
  // Without O_NONBLOCK, opening a pipe that nobody reads would wait for ever.
  fd_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
  if (fd_ < 0) return refuse("open", errno);
  if (::fcntl(fd_, F_SETFL, 0) != 0) return refuse("open", errno);
  return {};
}

Result<void> OutputFile::open_beside(const Options& options) {
  struct stat there = {};
  const bool replaces = ::lstat(target_.c_str(), &there) == 0 && S_ISREG(there.st_mode);
  // What replaces a file must not be readable for others before it has that file's mode.
  const mode_t mode = replaces ? 0600 : 0666;
  const std::filesystem::path folder = folder_of(target_);
  if (options.may_be_unnamed) {
    fd_ = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, mode);
    if (fd_ >= 0 && ::access(proc_name(fd_).c_str(), F_OK) != 0) {
      ::close(fd_);
      fd_ = -1;
    }
  }
  for (int attempt = 0; fd_ < 0 && attempt < 100; ++attempt) {
    beside_ = folder / random_name();
    fd_ = ::open(beside_.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC, mode);
    if (fd_ >= 0) break;
    const int error_number = errno;
    beside_.clear();
    if (error_number != EEXIST) return refuse("create", error_number);
  }
  if (fd_ < 0) return refuse("create", EEXIST);
  if (!replaces) return {};

  mode_t kept = there.st_mode & kPermissions;
  struct stat ours = {};
  if (::fstat(fd_, &ours) != 0) return refuse("create", errno);
  const bool has_owner = (ours.st_uid == there.st_uid && ours.st_gid == there.st_gid) || ::fchown(fd_, there.st_uid, there.st_gid) == 0;
  // The owner of a file can give it to any of their groups. Where even that is not possible, the group gets
  // no more than all others have.
  const bool has_group = has_owner || ours.st_gid == there.st_gid || ::fchown(fd_, static_cast<uid_t>(-1), there.st_gid) == 0;
  if (!has_group) kept = (kept & ~mode_t{0070}) | ((kept & 0007) << 3 & kept);
  if (::fchmod(fd_, kept) != 0) return refuse("create", errno);
  return {};
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      target_(std::move(other.target_)),
      beside_(std::exchange(other.beside_, {})),
      fd_(std::exchange(other.fd_, -1)),
      is_stream_(other.is_stream_),
      sync_(other.sync_),
      end_(other.end_),
      pending_(std::move(other.pending_)),
      pending_at_(other.pending_at_),
      failure_(std::move(other.failure_)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(target_, other.target_);
  std::swap(beside_, other.beside_);
  std::swap(fd_, other.fd_);
  std::swap(is_stream_, other.is_stream_);
  std::swap(sync_, other.sync_);
  std::swap(end_, other.end_);
  std::swap(pending_, other.pending_);
  std::swap(pending_at_, other.pending_at_);
  std::swap(failure_, other.failure_);
  return *this;
}

OutputFile::~OutputFile() { discard(); }

void OutputFile::discard() {
  if (!beside_.empty()) ::unlink(std::exchange(beside_, {}).c_str());
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

tl::unexpected<Error> OutputFile::refuse(std::string_view act, int error_number) {
  failure_ = Error{ErrorCode::kIo, path_.string() + ": cannot " + std::string(act) + ": " + failure_text(error_number)};
  return tl::unexpected(*failure_);
}

Result<void> OutputFile::flush() {
  std::span<const std::byte> left = pending_;
  while (!left.empty()) {
    const ssize_t written =
        is_stream_ ? ::write(fd_, left.data(), left.size()) : ::pwrite(fd_, left.data(), left.size(), static_cast<off_t>(pending_at_));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return refuse("write", written < 0 ? errno : ENOSPC);
    pending_at_ += static_cast<std::uint64_t>(written);
    left = left.subspan(static_cast<std::size_t>(written));
  }
  pending_.clear();
  return {};
}

Result<void> OutputFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (failure_) return tl::unexpected(*failure_);
  if (is_stream_ && offset != end_) return refuse("write out of order", ESPIPE);
  if (pending_.empty()) pending_at_ = offset;
  if (offset != pending_at_ + pending_.size() || pending_.size() + bytes.size() > kBufferBytes) {
    VT_CHECK(flush());
    pending_at_ = offset;
  }
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  end_ = std::max(end_, offset + bytes.size());
  return pending_.size() > kBufferBytes ? flush() : Result<void>{};
}

Result<std::size_t> OutputFile::read_at(std::uint64_t offset, std::span<std::byte> out) {
  if (failure_) return tl::unexpected(*failure_);
  if (is_stream_) return refuse("read", ESPIPE);
  VT_CHECK(flush());
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(fd_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return refuse("read", errno);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

// The random name is there for a moment only: a rename replaces what has the target's name, a link does not.
Result<void> OutputFile::give_name() {
  for (int attempt = 0; beside_.empty() && attempt < 100; ++attempt) {
    const std::filesystem::path name = folder_of(target_) / random_name();
    if (::linkat(AT_FDCWD, proc_name(fd_).c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      beside_ = name;
    } else if (errno != EEXIST) {
      return refuse("put in its place", errno);
    }
  }
  if (beside_.empty()) return refuse("put in its place", EEXIST);
  if (::rename(beside_.c_str(), target_.c_str()) != 0) return refuse("put in its place", errno);
  beside_.clear();
  return {};
}

Result<void> OutputFile::finish() {
  if (failure_) return tl::unexpected(*failure_);
  VT_CHECK(flush());
  if (!is_stream_) {
    if (sync_)
      if (const int failed = sync_descriptor(fd_); failed != 0) return refuse("write", failed);
    VT_CHECK(give_name());
    // The file is in its place and whole; what fails here can neither be undone nor helped.
    if (sync_) static_cast<void>(sync_folder_of(target_));
  }
  // On Linux the descriptor is gone even when close reports EINTR.
  if (::close(std::exchange(fd_, -1)) != 0 && errno != EINTR) return refuse("close", errno);
  return {};
}

Result<void> write_whole_file(const std::filesystem::path& target, std::string_view text) {
  VT_ASSIGN(OutputFile file, OutputFile::create(target));
  VT_CHECK(file.append(std::as_bytes(std::span(text))));
  return file.finish();
}

}  // namespace vt::store
