// What a file is about to do, for tests that stand between a writer and the disk (disk full, torn write
// logs).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace vt::store {

struct FileOperation {
  enum class Kind { kWrite, kSync, kTruncate } kind;
  std::uint64_t offset = 0;
  std::span<const std::byte> bytes;
};
// Called before every operation; a non-zero errno makes it fail with that. Empty in production.
using FileHook = std::function<int(const FileOperation&)>;

}  // namespace vt::store
