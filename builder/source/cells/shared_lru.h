// Values that are dear to make, kept while they are used: the most recently used ones up to a budget, and at
// least one. Any number of threads. Two threads that want the same value make it once; the second waits.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <new>
#include <optional>
#include <unordered_map>
#include <utility>

#include "store/result.h"

namespace vt::source {

// `Cost` is a function object: what one value takes of the budget. `Hash` hashes a key.
template <class Key, class Hash, class Value, class Cost>
class SharedLru {
 public:
  explicit SharedLru(std::size_t budget) : budget_(budget) {}

  // The value of `key`, by `make` when nobody has it. Failures are not kept: the next caller tries again.
  [[nodiscard]] Result<Value> get(const Key& key, const std::function<Result<Value>()>& make) {
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto found = slots_.find(key);
      if (found == slots_.end()) break;
      if (found->second.value) return used(found->second);
      made_.wait(lock);
    }
    slots_.emplace(key, Slot{std::nullopt, by_age_.end()});
    lock.unlock();

    // Whatever happens, exceptions included, the slot must not stay empty: others wait for it.
    Result<Value> value = fail(ErrorCode::kIo, "not enough memory for one decoded block");
    try {
      value = make();
    } catch (const std::bad_alloc&) {
    } catch (const std::exception& e) {
      value = fail(ErrorCode::kInternal, std::string("decoding one block: ") + e.what());
    }

    lock.lock();
    if (value) {
      insert(key, *value);
    } else {
      slots_.erase(key);
    }
    made_.notify_all();
    return value;
  }

  // The value if it is there already.
  [[nodiscard]] std::optional<Value> peek(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto found = slots_.find(key);
    if (found == slots_.end() || !found->second.value) return std::nullopt;
    return used(found->second);
  }

 private:
  struct Slot {
    std::optional<Value> value;  // empty while a thread makes it
    typename std::list<Key>::iterator age;
  };

  // With mutex_ held.
  const Value& used(Slot& slot) {
    by_age_.splice(by_age_.begin(), by_age_, slot.age);
    return *slot.value;
  }
  void insert(const Key& key, const Value& value) {
    by_age_.push_front(key);
    slots_[key] = Slot{value, by_age_.begin()};
    used_ += Cost()(value);
    while (used_ > budget_ && by_age_.size() > 1) {
      const auto oldest = slots_.find(by_age_.back());
      used_ -= Cost()(*oldest->second.value);
      slots_.erase(oldest);
      by_age_.pop_back();
    }
  }

  std::size_t budget_;
  std::size_t used_ = 0;
  std::mutex mutex_;
  std::condition_variable made_;
  std::list<Key> by_age_;  // most recent first; values that are there only
  std::unordered_map<Key, Slot, Hash> slots_;
};

}  // namespace vt::source
