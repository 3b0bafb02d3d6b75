#include "store/io/folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace vt::store {

Result<void> sync_folder_of(const std::filesystem::path& path) {
  const std::filesystem::path folder = folder_of(path);
  const auto refused = [&](const char* act, int error_number) {
    return fail(ErrorCode::kIo, folder.string() + ": cannot " + act + ": " + std::generic_category().message(error_number));
  };
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return refused("open to sync", errno);
  int failed = 0;
  do {
    failed = ::fsync(fd) == 0 ? 0 : errno;
  } while (failed == EINTR);
  ::close(fd);
  // Some network file systems cannot sync a folder.
  if (failed != 0 && failed != EINVAL) return refused("sync", failed);
  return {};
}

}  // namespace vt::store
