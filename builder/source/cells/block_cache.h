// What the sources of a build remember together: decoded blocks up to a number of bytes, and the content
// hashes of stored blocks. Any number of threads and sources.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "builder/source/cells/shared_lru.h"
#include "store/io/content_hash.h"
#include "store/result.h"

namespace vt::source {

using Block = std::vector<std::byte>;
using BlockPtr = std::shared_ptr<const Block>;

// One piece of one source, as the source counts them.
struct BlockKey {
  std::uint64_t source = 0;  // from BlockCache::add_source()
  std::uint64_t block = 0;
  bool operator==(const BlockKey&) const = default;
};

class BlockCache {
 public:
  // At most `budget_bytes` of decoded blocks plus the one most recently used.
  explicit BlockCache(std::size_t budget_bytes) : budget_bytes_(budget_bytes), blocks_(budget_bytes), hashes_(kMostHashes) {}

  [[nodiscard]] std::size_t budget_bytes() const { return budget_bytes_; }
  // A number of its own for every source, so that their blocks are not mistaken for one another.
  static constexpr std::size_t kMostHashes = std::size_t{1} << 16;
  static constexpr std::size_t kBytesOfHash = 128;  // of one that is remembered, with all around it

  [[nodiscard]] std::uint64_t add_source() { return next_source_.fetch_add(1, std::memory_order_relaxed); }

  [[nodiscard]] Result<BlockPtr> get(const BlockKey& key, const std::function<Result<Block>()>& decode);
  [[nodiscard]] BlockPtr peek(const BlockKey& key) { return blocks_.peek(key).value_or(nullptr); }

  // The hash of a stored block: tens of bytes each, kept apart so that no amount of decoding drives them out.
  // A block is asked for again by every chunk of rows that crosses it, and a strip may be gigabytes.
  [[nodiscard]] Result<store::ContentHash> hash(const BlockKey& key, const std::function<Result<store::ContentHash>()>& make) {
    return hashes_.get(key, make);
  }

 private:
  struct KeyHash {
    std::size_t operator()(const BlockKey& key) const {
      return static_cast<std::size_t>((key.source * 0x9E3779B97F4A7C15U ^ key.block) * 0xD6E8FEB86659FD93U >> 7);
    }
  };
  struct BlockBytes {
    std::size_t operator()(const BlockPtr& block) const { return block->size(); }
  };
  struct One {
    std::size_t operator()(const store::ContentHash&) const { return 1; }
  };

  std::size_t budget_bytes_;
  std::atomic<std::uint64_t> next_source_ = 0;
  SharedLru<BlockKey, KeyHash, BlockPtr, BlockBytes> blocks_;
  SharedLru<BlockKey, KeyHash, store::ContentHash, One> hashes_;
};

}  // namespace vt::source
