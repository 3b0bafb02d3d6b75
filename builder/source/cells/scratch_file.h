// Room on a disk for samples that are decoded once and read more often, shared by the sources of a build. A
// file without a name: nothing of it stays, however the program ends. Any number of threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>

#include "store/result.h"

namespace vt::source {

class ScratchFile {
 public:
  // In this folder, made when it is first needed. With `most_bytes`, more than that at once is an error as if
  // the disk were full.
  explicit ScratchFile(std::filesystem::path folder, std::uint64_t most_bytes = UINT64_MAX)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile();

  // A range that nobody else has, starting on a page. It takes no room before it is written, and only
  // release() gives that back.
  [[nodiscard]] Result<std::uint64_t> reserve(std::uint64_t bytes);
  // kIo: names the folder, says when it is full.
  [[nodiscard]] Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> out) const;
  // Gives whole pages back. False: this file system cannot, and the bytes are still there.
  [[nodiscard]] bool release(std::uint64_t offset, std::uint64_t bytes);

  [[nodiscard]] std::uint64_t bytes_on_disk() const;

  static constexpr std::uint64_t kPageBytes = 4096;

 private:
  [[nodiscard]] Result<void> create();  // with mutex_ held
  [[nodiscard]] tl::unexpected<Error> refusal(const char* act, int error_number) const;

  const std::filesystem::path folder_;
  const std::uint64_t most_bytes_;
  mutable std::mutex mutex_;
  std::atomic<int> descriptor_ = -1;  // set once, by the first reserve()
  std::uint64_t reserved_ = 0;
};

}  // namespace vt::source
