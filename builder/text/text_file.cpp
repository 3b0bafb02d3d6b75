#include "builder/text/text_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace vt::text {

Result<std::string> read_text_file(const std::filesystem::path& path, std::size_t most_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (error && status.type() != std::filesystem::file_type::not_found) return fail(ErrorCode::kIo, path.string() + ": " + error.message());
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return fail(ErrorCode::kIo, path.string() + ": is no file but a folder, a pipe or a device");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return fail(ErrorCode::kIo, path.string() + ": cannot be opened: " + std::strerror(errno));
  std::string content;
  std::array<char, 1 << 16> piece{};
  // Piece by piece: what the file's size is said to be need not be true.
  while (file.read(piece.data(), piece.size()) || file.gcount() > 0) {
    content.append(piece.data(), static_cast<std::size_t>(file.gcount()));
    if (content.size() > most_bytes)
      return fail(ErrorCode::kIo, path.string() + ": is longer than " + std::to_string(most_bytes) + " bytes, the most that is read here");
  }
  if (file.bad()) return fail(ErrorCode::kIo, path.string() + ": cannot be read: " + std::strerror(errno));
  return content;
}

}  // namespace vt::text
