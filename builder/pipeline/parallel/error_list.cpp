#include "builder/pipeline/parallel/error_list.h"

#include <string>

namespace vt::pipeline {

Result<void> ErrorList::result() const {
  const Error* first = nullptr;
  std::size_t count = 0;
  std::string lines;
  for (const std::optional<Error>& error : errors_) {
    if (!error) continue;
    if (++count == 1) first = &*error;
    if (count <= kMostListed) lines += "\n  " + error->message;
  }
  if (count == 0) return {};
  if (count == 1) return tl::unexpected(*first);
  if (count > kMostListed) lines += "\n  and " + std::to_string(count - kMostListed) + " more";
  return fail(first->code, std::to_string(count) + " of " + std::to_string(errors_.size()) + " sources cannot be used:" + lines);
}

}  // namespace vt::pipeline
