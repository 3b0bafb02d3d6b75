// Decoders that stand somewhere in a file, kept idle for whoever reads that file next: they are dear to make,
// and large. At most so many for all sources of a build; the one idle longest goes first. Any number of
// threads.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>

namespace vt::source {

class IdleReader {
 public:
  IdleReader() = default;
  IdleReader(const IdleReader&) = delete;
  IdleReader& operator=(const IdleReader&) = delete;
  virtual ~IdleReader() = default;
};

class ReaderPool {
 public:
  explicit ReaderPool(std::size_t most_idle) : most_idle_(most_idle) {}

  // The owner's reader with the highest score, the most recently used of equals; null when none is idle. The
  // lock is held while `score` runs.
  [[nodiscard]] std::unique_ptr<IdleReader> take(const void* owner, const std::function<double(const IdleReader&)>& score);
  void give(const void* owner, std::unique_ptr<IdleReader> reader);
  void forget(const void* owner);  // closes what it left here
  void clear();

 private:
  struct Entry {
    const void* owner;
    std::unique_ptr<IdleReader> reader;
  };

  std::size_t most_idle_;
  std::mutex mutex_;
  std::list<Entry> by_age_;  // most recent first
};

}  // namespace vt::source
