#include "builder/source/files/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace vt::source {

namespace {

std::string kind_text(mode_t mode) {
  if (S_ISDIR(mode)) return "it is a folder";
  if (S_ISFIFO(mode)) return "it is a pipe, and a regular file is needed";
  if (S_ISSOCK(mode)) return "it is a socket, and a regular file is needed";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "it is a device, and a regular file is needed";
  return "it is not a regular file";
}

tl::unexpected<Error> unreadable(const std::filesystem::path& path, const std::string& why) {
  return fail(ErrorCode::kIo, fmt::format("{}: cannot read it: {}", path.string(), why));
}

}  // namespace

Result<void> check_regular_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return unreadable(path, std::generic_category().message(errno));
  if (!S_ISREG(status.st_mode)) return unreadable(path, kind_text(status.st_mode));
  return {};
}

// Gives the descriptor back.
class FileBytes::Lease {
 public:
  explicit Lease(const FileBytes& file) : file_(file) {}
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  ~Lease() { file_.pool_->release(file_.slot_); }

 private:
  const FileBytes& file_;
};

tl::unexpected<Error> FileBytes::refusal(const std::string& why) const { return unreadable(path_, why); }

tl::unexpected<Error> FileBytes::changed(const Identity& found) const {
  return fail(ErrorCode::kIo,
              fmt::format("{}: it has changed since it was opened ({} bytes then, {} now, or replaced); sources must stay as "
                          "they are while they are read: run the command again",
                          path_.string(), identity_.size, found.size));
}

Result<int> FileBytes::open_descriptor(Identity& found) const {
  // Looked at before it is opened: opening waits for a pipe's writer, and a device may act.
  VT_CHECK(check_regular_file(path_));
  constexpr int kFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK;
  int descriptor = ::open(path_.c_str(), kFlags);
  if (descriptor < 0 && (errno == EMFILE || errno == ENFILE)) {
    pool_->close_all_idle();
    descriptor = ::open(path_.c_str(), kFlags);
  }
  if (descriptor < 0) return refusal(std::generic_category().message(errno));
  struct stat status {};
  const int failed = ::fstat(descriptor, &status) == 0 ? 0 : errno;
  if (failed != 0 || !S_ISREG(status.st_mode)) {  // another one since
    ::close(descriptor);
    return refusal(failed != 0 ? std::generic_category().message(failed) : kind_text(status.st_mode));
  }
  found = {.device = static_cast<std::uint64_t>(status.st_dev),
           .inode = static_cast<std::uint64_t>(status.st_ino),
           .size = static_cast<std::uint64_t>(status.st_size),
           .modified_s = status.st_mtim.tv_sec,
           .modified_ns = status.st_mtim.tv_nsec};
  return descriptor;
}

Result<std::shared_ptr<const FileBytes>> FileBytes::open(const std::filesystem::path& path, std::shared_ptr<FilePool> pool) {
  if (!pool) pool = std::make_shared<FilePool>();
  const std::shared_ptr<FileBytes> file(new FileBytes(path, std::move(pool)));
  VT_ASSIGN(const int descriptor, file->open_descriptor(file->identity_));
  static_cast<void>(file->pool_->adopt(file->slot_, descriptor));
  const Lease lease(*file);
  return file;
}

FileBytes::~FileBytes() { pool_->forget(slot_); }

Result<int> FileBytes::borrow() const {
  if (const int open = pool_->acquire(slot_); open >= 0) return open;
  Identity found;
  VT_ASSIGN(const int descriptor, open_descriptor(found));
  if (found != identity_) {
    ::close(descriptor);
    return changed(found);
  }
  return pool_->adopt(slot_, descriptor);
}

Result<void> FileBytes::check_unchanged() const {
  Identity found;
  VT_ASSIGN(const int descriptor, open_descriptor(found));
  ::close(descriptor);
  if (found != identity_) return changed(found);
  return {};
}

Result<std::size_t> FileBytes::read_some(std::uint64_t offset, std::span<std::byte> out) const {
  VT_ASSIGN(const int descriptor, borrow());
  const Lease lease(*this);
  std::size_t done = 0;
  while (done < out.size() && offset + done < size()) {
    const ssize_t got = ::pread(descriptor, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      return fail(ErrorCode::kIo,
                  fmt::format("{}: reading at byte {}: {}", path_.string(), offset + done, std::generic_category().message(errno)));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

void FileBytes::expect(std::uint64_t offset, std::uint64_t bytes) const {
  const Result<int> descriptor = borrow();
  if (!descriptor) return;  // the read itself will say why
  const Lease lease(*this);
  [[maybe_unused]] const int ignored =
      ::posix_fadvise(*descriptor, static_cast<off_t>(offset), static_cast<off_t>(bytes), POSIX_FADV_WILLNEED);
}

}  // namespace vt::source
