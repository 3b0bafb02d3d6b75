#include "builder/source/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace vt::source {

Result<std::shared_ptr<const FileBytes>> FileBytes::open(const std::filesystem::path& path) {
  const auto refusal = [&](const std::string& why) {
    return fail(ErrorCode::kIo, fmt::format("{}: cannot read it: {}", path.string(), why));
  };
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return refusal(std::generic_category().message(errno));
  struct stat status {};
  const int failed = ::fstat(descriptor, &status) == 0 ? 0 : errno;
  if (failed != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    if (failed != 0) return refusal(std::generic_category().message(failed));
    return refusal(S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file");
  }
  return std::shared_ptr<const FileBytes>(new FileBytes(path, descriptor, static_cast<std::uint64_t>(status.st_size)));
}

FileBytes::~FileBytes() { ::close(descriptor_); }

Result<std::size_t> FileBytes::read_some(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size() && offset + done < size_) {
    const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      return fail(ErrorCode::kIo,
                  fmt::format("{}: reading at byte {}: {}", path_.string(), offset + done, std::generic_category().message(errno)));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

}  // namespace vt::source
