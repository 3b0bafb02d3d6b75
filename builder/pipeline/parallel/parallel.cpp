#include "builder/pipeline/parallel/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

namespace vt::pipeline {

int thread_count(int requested) { return requested > 0 ? requested : std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

Error error_of(const std::exception& problem) {
  if (dynamic_cast<const std::bad_alloc*>(&problem) != nullptr)
    return {ErrorCode::kIo, "not enough memory; less of it (`memory`) and fewer threads (`threads`) need less"};
  if (dynamic_cast<const std::system_error*>(&problem) != nullptr)
    return {ErrorCode::kIo, std::string("the system refused something that is needed: ") + problem.what()};
  return {ErrorCode::kInternal, problem.what()};
}

Result<void> for_each_index(std::size_t count, int threads, const std::function<Result<void>(std::size_t)>& step) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t failed_at = count;  // under the mutex
  std::optional<Error> error;     // under the mutex
  const auto guarded = [&](std::size_t index) -> Result<void> {
    try {
      return step(index);
    } catch (const std::exception& problem) {
      return tl::unexpected(error_of(problem));
    }
  };
  // Numbers are handed out in order, so every smaller one has been begun when a step fails, and will be heard
  // before the threads are joined.
  const auto work = [&] {
    for (std::size_t index = next++; index < count; index = next++) {
      auto result = guarded(index);
      if (result) continue;
      const std::lock_guard lock(mutex);
      next = count;
      if (index < failed_at) {
        failed_at = index;
        error = std::move(result).error();
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    const std::size_t wanted = std::min(count, static_cast<std::size_t>(std::max(threads, 1)));
    try {
      for (std::size_t i = 1; i < wanted; ++i) helpers.emplace_back(work);
    } catch (const std::system_error&) {
      // The system has no more threads to give; those that there are do the work.
    }
    work();
  }
  if (error) return tl::unexpected(std::move(*error));
  return {};
}

}  // namespace vt::pipeline
