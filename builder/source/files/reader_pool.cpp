#include "builder/source/files/reader_pool.h"

#include <utility>

namespace vt::source {

std::unique_ptr<IdleReader> ReaderPool::take(const void* owner, const std::function<double(const IdleReader&)>& score) {
  const std::scoped_lock lock(mutex_);
  auto best = by_age_.end();
  double best_score = 0.0;
  for (auto entry = by_age_.begin(); entry != by_age_.end(); ++entry) {
    if (entry->owner != owner) continue;
    const double entry_score = score(*entry->reader);
    if (best == by_age_.end() || entry_score > best_score) {
      best = entry;
      best_score = entry_score;
    }
  }
  if (best == by_age_.end()) return nullptr;
  std::unique_ptr<IdleReader> reader = std::move(best->reader);
  by_age_.erase(best);
  return reader;
}

void ReaderPool::give(const void* owner, std::unique_ptr<IdleReader> reader) {
  std::list<Entry> too_many;  // closed without the lock
  const std::scoped_lock lock(mutex_);
  by_age_.push_front({owner, std::move(reader)});
  if (by_age_.size() > most_idle_) too_many.splice(too_many.begin(), by_age_, std::prev(by_age_.end()));
}

void ReaderPool::forget(const void* owner) {
  std::list<Entry> forgotten;
  const std::scoped_lock lock(mutex_);
  for (auto entry = by_age_.begin(); entry != by_age_.end();) {
    const auto next = std::next(entry);
    if (entry->owner == owner) forgotten.splice(forgotten.begin(), by_age_, entry);
    entry = next;
  }
}

void ReaderPool::clear() {
  std::list<Entry> all;
  const std::scoped_lock lock(mutex_);
  all.swap(by_age_);
}

}  // namespace vt::source
