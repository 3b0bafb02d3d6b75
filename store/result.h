// The one way in which ordinary failures travel: a value or an Error that tells the user what to do. Wrong
// calls are bugs and use assert; bad files, disks and configurations come back as Result. Everything here may
// be used from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace vt {

enum class ErrorCode : std::uint8_t {
  kUsage,        // the caller asked for something that makes no sense: exit code 1
  kIo,           // the operating system refused: missing file, disk full, no permission: exit code 2
  kNotFound,     // the thing asked for is absent, which may be quite normal (a sparse tile)
  kExists,       // would overwrite something, or the store has another writer: exit code 2
  kInvalidData,  // a file or a configuration breaks its format: exit code 3
  kUnsupported,  // valid, but not something this program can read: exit code 3
  kCorrupt,      // a checksum differs: exit code 3
  kCancelled,    // the user asked to stop; what was committed stays
  kInternal,     // a bug of ours: exit code 4
};

// `message` is one sentence or two: file, place, found, wanted, what to do.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace vt

// Leaves the current function with the error of `expr` when it has one. For Result<void>.
#define VT_CHECK(expr)                                                          \
  do {                                                                          \
    if (auto vt_check_result = (expr); !vt_check_result) [[unlikely]]           \
      return ::tl::unexpected<::vt::Error>(std::move(vt_check_result).error()); \
  } while (false)

#define VT_CONCAT_INNER(a, b) a##b
#define VT_CONCAT(a, b) VT_CONCAT_INNER(a, b)

// `VT_ASSIGN(auto header, decode_header(bytes));` declares the value or leaves with the error.
#define VT_ASSIGN(declaration, expr)                                                          \
  auto VT_CONCAT(vt_result_, __LINE__) = (expr);                                              \
  if (!VT_CONCAT(vt_result_, __LINE__)) [[unlikely]]                                          \
    return ::tl::unexpected<::vt::Error>(std::move(VT_CONCAT(vt_result_, __LINE__)).error()); \
  declaration = std::move(*VT_CONCAT(vt_result_, __LINE__))
