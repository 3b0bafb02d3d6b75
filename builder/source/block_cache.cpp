#include "builder/source/block_cache.h"

#include <new>

namespace vt::source {

Result<BlockPtr> BlockCache::get(std::uint64_t key, const std::function<Result<Block>()>& decode) {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto found = slots_.find(key);
    if (found == slots_.end()) break;
    if (found->second.block) {
      by_age_.splice(by_age_.begin(), by_age_, found->second.age);
      return found->second.block;
    }
    decoded_.wait(lock);
  }
  slots_.emplace(key, Slot{nullptr, by_age_.end()});
  lock.unlock();

  // An exception (out of memory) must not leave the others waiting for a block that never comes.
  // Whatever happens, the slot must not stay empty: others wait for it.
  Result<BlockPtr> shared = fail(ErrorCode::kInternal, "out of memory for one decoded block");
  try {
    shared = decode().map([](Block&& block) -> BlockPtr { return std::make_shared<const Block>(std::move(block)); });
  } catch (const std::bad_alloc&) {
  } catch (const std::exception& e) {
    shared = fail(ErrorCode::kInternal, std::string("decoding one block: ") + e.what());
  }

  lock.lock();
  if (!shared) {
    slots_.erase(key);
    decoded_.notify_all();
    return tl::unexpected(std::move(shared).error());
  }
  insert(key, *shared);
  decoded_.notify_all();
  return shared;
}

BlockPtr BlockCache::peek(std::uint64_t key) {
  const std::scoped_lock lock(mutex_);
  const auto found = slots_.find(key);
  if (found == slots_.end() || !found->second.block) return nullptr;
  by_age_.splice(by_age_.begin(), by_age_, found->second.age);
  return found->second.block;
}

void BlockCache::insert(std::uint64_t key, const BlockPtr& block) {
  by_age_.push_front(key);
  slots_[key] = Slot{block, by_age_.begin()};
  used_bytes_ += block->size();
  while (used_bytes_ > budget_bytes_ && by_age_.size() > 1) {
    const auto oldest = slots_.find(by_age_.back());
    used_bytes_ -= oldest->second.block->size();
    slots_.erase(oldest);
    by_age_.pop_back();
  }
}

}  // namespace vt::source
