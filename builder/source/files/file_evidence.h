// What is known of a file before anything of it is decoded: enough to tell its format. Plain values, any
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "builder/source/files/file_bytes.h"
#include "store/result.h"

namespace vt::source {

struct FileEvidence {
  std::string head;  // its first bytes, 1024 of them at most
  std::uint64_t size = 0;
  std::filesystem::path path;

  [[nodiscard]] static Result<FileEvidence> of(const FileBytes& file);  // kIo
  [[nodiscard]] bool has(std::size_t at, std::string_view bytes) const;
  [[nodiscard]] std::string suffix() const;  // ".tif", in lower case
  // The head without white space or a byte order mark at its start, in lower case.
  [[nodiscard]] std::string text() const;
};

[[nodiscard]] std::string in_lower_case(std::string text);

}  // namespace vt::source
