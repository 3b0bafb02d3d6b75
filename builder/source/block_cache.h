// The decoded blocks of one source: at most `budget_bytes` of them plus the one most recently used, shared by all threads.
// Two threads that want the same block decode it once; the second waits.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "store/result.h"

namespace vt::source {

using Block = std::vector<std::byte>;
using BlockPtr = std::shared_ptr<const Block>;

class BlockCache {
 public:
  explicit BlockCache(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  // The block `key`, made by `decode` when nobody has it. Failures are not kept: the next caller tries again.
  [[nodiscard]] Result<BlockPtr> get(std::uint64_t key, const std::function<Result<Block>()>& decode);
  // The block if it is there already.
  [[nodiscard]] BlockPtr peek(std::uint64_t key);

 private:
  struct Slot {
    BlockPtr block;  // null while a thread is decoding it
    std::list<std::uint64_t>::iterator age;
  };
  void insert(std::uint64_t key, const BlockPtr& block);  // with mutex_ held

  std::size_t budget_bytes_;
  std::size_t used_bytes_ = 0;
  std::mutex mutex_;
  std::condition_variable decoded_;
  std::list<std::uint64_t> by_age_;  // most recent first; decoded blocks only
  std::unordered_map<std::uint64_t, Slot> slots_;
};

}  // namespace vt::source
