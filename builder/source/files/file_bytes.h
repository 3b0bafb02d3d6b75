// A file that is read at any offset, by any number of threads. It is known by what it was when it was first
// opened; its descriptor is lent by a FilePool, which may close it between two reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "builder/source/files/file_pool.h"
#include "store/result.h"

namespace vt::source {

// kIo unless there is a regular file under this path, or a link to one: whoever opens anything else may wait
// for ever. The message names the file and what it is.
[[nodiscard]] Result<void> check_regular_file(const std::filesystem::path& path);

class FileBytes {
 public:
  // Without a pool the file makes one of its own. kIo: the system refuses it, or it is no regular file; a
  // pipe or a device is not waited for.
  [[nodiscard]] static Result<std::shared_ptr<const FileBytes>> open(const std::filesystem::path& path,
                                                                     std::shared_ptr<FilePool> pool = nullptr);
  ~FileBytes();
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return identity_.size; }  // when it was opened
  [[nodiscard]] const std::shared_ptr<FilePool>& pool() const { return pool_; }

  // Reads up to out.size() bytes; less at the end of the file. kIo: the operating system refused, or the file
  // is another one than when it was opened.
  [[nodiscard]] Result<std::size_t> read_some(std::uint64_t offset, std::span<std::byte> out) const;
  // Asks the system to begin reading this part from the disk, so that a later read need not wait. A hint:
  // does not wait, cannot fail.
  void expect(std::uint64_t offset, std::uint64_t bytes) const;
  // kIo when the file under this path is no longer the one that was opened: for readers that open it by its
  // path.
  [[nodiscard]] Result<void> check_unchanged() const;

 private:
  struct Identity {
    std::uint64_t device = 0;
    std::uint64_t inode = 0;
    std::uint64_t size = 0;
    std::int64_t modified_s = 0;
    std::int64_t modified_ns = 0;
    bool operator==(const Identity&) const = default;
  };
  class Lease;

  FileBytes(std::filesystem::path path, std::shared_ptr<FilePool> pool) : path_(std::move(path)), pool_(std::move(pool)) {}
  // A new descriptor, and what it leads to.
  [[nodiscard]] Result<int> open_descriptor(Identity& found) const;
  [[nodiscard]] Result<int> borrow() const;
  [[nodiscard]] tl::unexpected<Error> refusal(const std::string& why) const;
  [[nodiscard]] tl::unexpected<Error> changed(const Identity& found) const;

  std::filesystem::path path_;
  std::shared_ptr<FilePool> pool_;
  Identity identity_;
  mutable FilePool::Slot slot_;
};

}  // namespace vt::source
