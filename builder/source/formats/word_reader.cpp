#include "builder/source/formats/word_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace vt::source {
namespace {

bool is_white(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace

WordReader::WordReader(const FileBytes& file, std::uint64_t at) : file_(file), buffer_(kBufferBytes), at_(at) {}

Result<bool> WordReader::refill() {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
  at_ += begin_;
  filled_ -= begin_;
  end_ -= begin_;
  begin_ = 0;
  VT_ASSIGN(const std::size_t got, file_.read_some(at_ + filled_, std::as_writable_bytes(std::span(buffer_).subspan(filled_))));
  filled_ += got;
  return got > 0;
}

Result<std::string_view> WordReader::next() {
  begin_ = end_;
  for (;;) {
    while (begin_ < filled_ && is_white(buffer_[begin_])) ++begin_;
    end_ = begin_;
    if (begin_ < filled_) break;
    VT_ASSIGN(const bool has_more, refill());
    if (!has_more) return std::string_view();
  }
  for (;;) {
    while (end_ < filled_ && !is_white(buffer_[end_])) ++end_;
    if (end_ - begin_ > kMostWordBytes)
      return fail(ErrorCode::kInvalidData,
                  fmt::format("{}: the word at byte {} is longer than any number", file_.path().string(), word_at()));
    if (end_ < filled_) break;
    VT_ASSIGN(const bool has_more, refill());
    if (!has_more) break;
  }
  return std::string_view(buffer_.data() + begin_, end_ - begin_);
}

}  // namespace vt::source
