// Words of a text file one after the other, however they are spread over lines, in little memory whatever the
// file is. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "store/result.h"

namespace vt::source {

class WordReader {
 public:
  WordReader(const FileBytes& file, std::uint64_t at);

  // Until the next call; "" at the end of the file. kIo. kInvalidData: a word of more than kMostWordBytes.
  [[nodiscard]] Result<std::string_view> next();
  [[nodiscard]] std::uint64_t word_at() const { return at_ + begin_; }  // where in the file the last word begins

  static constexpr std::size_t kMostWordBytes = 128;
  static constexpr std::size_t kBufferBytes = std::size_t{64} << 10;

 private:
  // What is left moves to the front, and more comes behind it. False at the end of the file.
  [[nodiscard]] Result<bool> refill();

  const FileBytes& file_;
  std::vector<char> buffer_;
  std::uint64_t at_;        // of the buffer in the file
  std::size_t begin_ = 0;   // of the last word
  std::size_t end_ = 0;     // behind it
  std::size_t filled_ = 0;  // bytes in the buffer
};

}  // namespace vt::source
