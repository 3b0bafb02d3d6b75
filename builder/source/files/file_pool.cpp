#include "builder/source/files/file_pool.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace vt::source {
namespace {

void close_each(const std::vector<int>& descriptors) {
  for (const int descriptor : descriptors) ::close(descriptor);
}

}  // namespace

std::size_t FilePool::default_limit() {
  constexpr std::size_t kMost = 256;
  constexpr std::size_t kLeast = 4;
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kMost;
  return static_cast<std::size_t>(std::clamp<rlim_t>(limit.rlim_cur / 4, kLeast, kMost));
}

FilePool::FilePool(std::size_t most_descriptors)
    : most_descriptors_(most_descriptors != 0 ? most_descriptors : default_limit()),
      readers_(std::min(kMostIdleReaders, most_descriptors_)) {}

std::size_t FilePool::open_descriptors() const {
  const std::scoped_lock lock(mutex_);
  return by_age_.size();
}

int FilePool::acquire(Slot& slot) {
  const std::scoped_lock lock(mutex_);
  if (slot.descriptor < 0) return -1;
  ++slot.users;
  by_age_.splice(by_age_.begin(), by_age_, slot.age);
  return slot.descriptor;
}

int FilePool::adopt(Slot& slot, int descriptor) {
  std::vector<int> surplus;
  int chosen = -1;
  {
    const std::scoped_lock lock(mutex_);
    ++slot.users;
    if (slot.descriptor >= 0) {
      surplus.push_back(descriptor);
    } else {
      slot.descriptor = descriptor;
      by_age_.push_front(&slot);
      slot.age = by_age_.begin();
    }
    chosen = slot.descriptor;
    for (auto oldest = by_age_.end(); by_age_.size() > most_descriptors_ && oldest != by_age_.begin();) {
      --oldest;
      Slot& other = **oldest;
      if (other.users > 0) continue;
      surplus.push_back(std::exchange(other.descriptor, -1));
      oldest = by_age_.erase(oldest);
    }
  }
  close_each(surplus);
  return chosen;
}

void FilePool::release(Slot& slot) {
  const std::scoped_lock lock(mutex_);
  --slot.users;
}

void FilePool::forget(Slot& slot) {
  std::vector<int> surplus;
  {
    const std::scoped_lock lock(mutex_);
    if (slot.descriptor < 0) return;
    surplus.push_back(std::exchange(slot.descriptor, -1));
    by_age_.erase(slot.age);
  }
  close_each(surplus);
}

void FilePool::close_all_idle() {
  readers_.clear();
  std::vector<int> surplus;
  {
    const std::scoped_lock lock(mutex_);
    for (auto each = by_age_.begin(); each != by_age_.end();) {
      Slot& slot = **each;
      if (slot.users > 0) {
        ++each;
        continue;
      }
      surplus.push_back(std::exchange(slot.descriptor, -1));
      each = by_age_.erase(each);
    }
  }
  close_each(surplus);
}

}  // namespace vt::source
