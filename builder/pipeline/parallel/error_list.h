// What is wrong with many files, told together: a person mends them in one go instead of finding the next
// after each run.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "store/result.h"

namespace vt::pipeline {

class ErrorList {
 public:
  explicit ErrorList(std::size_t files) : errors_(files) {}
  // The error of file number `i`; each by one thread. The message names the file.
  void set(std::size_t i, Error error) { errors_[i] = std::move(error); }
  // Nothing, the only error as it is, or one message with all of them in order, cut short after kMostListed.
  // Its code is the first's.
  [[nodiscard]] Result<void> result() const;

  static constexpr std::size_t kMostListed = 20;

 private:
  std::vector<std::optional<Error>> errors_;
};

}  // namespace vt::pipeline
