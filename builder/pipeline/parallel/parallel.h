// The same step for many independent things on several threads, with an outcome that does not depend on who
// was faster.
#pragma once

#include <cstddef>
#include <exception>
#include <functional>

#include "store/result.h"

namespace vt::pipeline {

// As many as the machine has when `requested` is 0; at least 1.
[[nodiscard]] int thread_count(int requested);

// What an exception becomes that ended a piece of work: lack of memory is kIo, all else kInternal.
[[nodiscard]] Error error_of(const std::exception& problem);

// Calls step(0) to step(count - 1), each once, on up to `threads` threads. After an error no further steps
// are begun; the error returned is that of the smallest number, as if the steps had been done in order. An
// exception in a step is as error_of() says.
[[nodiscard]] Result<void> for_each_index(std::size_t count, int threads, const std::function<Result<void>(std::size_t)>& step);

}  // namespace vt::pipeline
