#include "builder/source/cells/scratch_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace vt::source {

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tl::unexpected<Error> ScratchFile::refusal(const char* act, int error_number) const {
  const bool is_full = error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
  return fail(
      ErrorCode::kIo,
      fmt::format("{}: {} the scratch file for decoded samples: {}{}", folder_.string(), act, std::generic_category().message(error_number),
                  is_full ? fmt::format(" ({} MB are in use there); free some space, or rewrite the source as tiled TIFF, which needs none",
                                        bytes_on_disk() >> 20)
                          : ""));
}

Result<void> ScratchFile::create() {
  descriptor_ = ::open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC | O_EXCL, S_IRUSR | S_IWUSR);
  if (descriptor_ >= 0) return {};
  // Some file systems have no files without a name; then it loses its name at once.
  std::string name = (folder_ / ".vt-scratch-XXXXXX").string();
  descriptor_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0) return refusal("cannot make", errno);
  ::unlink(name.c_str());
  return {};
}

Result<std::uint64_t> ScratchFile::reserve(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  if (descriptor_ < 0) VT_CHECK(create());
  const std::uint64_t offset = reserved_;
  reserved_ += (bytes + kPageBytes - 1) / kPageBytes * kPageBytes;
  return offset;
}

Result<void> ScratchFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (most_bytes_ != UINT64_MAX && bytes_on_disk() + bytes.size() > most_bytes_) return refusal("cannot write", ENOSPC);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return refusal("cannot write", errno);
    if (put == 0) return refusal("cannot write", ENOSPC);
    done += static_cast<std::size_t>(put);
  }
  return {};
}

Result<void> ScratchFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  for (std::size_t done = 0; done < out.size();) {
    const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return refusal("cannot read", errno);
    if (got == 0) return refusal("cannot read", EIO);
    done += static_cast<std::size_t>(got);
  }
  return {};
}

bool ScratchFile::release(std::uint64_t offset, std::uint64_t bytes) {
  return ::fallocate(descriptor_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset), static_cast<off_t>(bytes)) == 0;
}

std::uint64_t ScratchFile::bytes_on_disk() const {
  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) return 0;
  return static_cast<std::uint64_t>(status.st_blocks) * 512;
}

}  // namespace vt::source
