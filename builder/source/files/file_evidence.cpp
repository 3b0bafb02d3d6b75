#include "builder/source/files/file_evidence.h"

#include <algorithm>
#include <cctype>
#include <span>

namespace vt::source {

Result<FileEvidence> FileEvidence::of(const FileBytes& file) {
  constexpr std::size_t kHeadBytes = 1024;
  FileEvidence evidence{.head = std::string(kHeadBytes, '\0'), .size = file.size(), .path = file.path()};
  VT_ASSIGN(const std::size_t got, file.read_some(0, std::as_writable_bytes(std::span(evidence.head))));
  evidence.head.resize(got);
  return evidence;
}

bool FileEvidence::has(std::size_t at, std::string_view bytes) const {
  return head.size() >= at + bytes.size() && std::string_view(head).substr(at, bytes.size()) == bytes;
}

std::string FileEvidence::suffix() const { return in_lower_case(path.extension().string()); }

std::string FileEvidence::text() const {
  const std::size_t begin = std::min(head.find_first_not_of(" \t\r\n\xef\xbb\xbf"), head.size());
  return in_lower_case(head.substr(begin));
}

std::string in_lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace vt::source
