// Bytes of a picture's header, and the numbers in them. Every length and count is checked against the file.
// Private to this folder.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "builder/source/files/file_bytes.h"
#include "builder/source/picture/picture_header.h"
#include "store/result.h"

namespace vt::source {

// Pieces of a file that a header may be made of: hostile files have many, of no use.
inline constexpr int kMostPieces = 1 << 17;
inline constexpr std::uint64_t kMostStoredProfileBytes = std::uint64_t{4} << 20;

// Numbers of one to four bytes; 0 where the text ends before them.
[[nodiscard]] std::uint32_t read_big(std::string_view bytes, std::size_t at, std::size_t count = 4);
[[nodiscard]] std::uint32_t read_little(std::string_view bytes, std::size_t at, std::size_t count = 4);
// A size in bytes that may exceed every integer, or be none, as a whole number.
[[nodiscard]] std::uint64_t whole_bytes(double bytes);
[[nodiscard]] inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// A number without anything behind it.
template <class T>
std::optional<T> number_of(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// Some bytes of a file. Not a string: those keep short texts inside, which GCC 12 takes for uninitialised
// memory here.
class Piece {
 public:
  explicit Piece(std::size_t bytes) : bytes_(bytes) {}
  [[nodiscard]] std::span<std::byte> writable() { return std::as_writable_bytes(std::span(bytes_)); }
  void shorten(std::size_t bytes) { bytes_.resize(bytes); }
  [[nodiscard]] std::string_view view() const { return {bytes_.data(), bytes_.size()}; }

 private:
  std::vector<char> bytes_;
};

class HeaderBytes {
 public:
  explicit HeaderBytes(const FileBytes& file) : file_(file) {}

  [[nodiscard]] std::uint64_t size() const { return file_.size(); }
  [[nodiscard]] tl::unexpected<Error> damaged(const std::string& what) const;
  [[nodiscard]] tl::unexpected<Error> unsupported(const std::string& what) const;
  // Exactly so many bytes.
  [[nodiscard]] Result<Piece> part(std::uint64_t at, std::uint64_t bytes) const;
  // Fewer at the end of the file.
  [[nodiscard]] Result<Piece> up_to(std::uint64_t at, std::uint64_t bytes) const;

 private:
  const FileBytes& file_;
};

// The orientation in Exif data, which are a TIFF stream: tag 274 of its first directory, 1 when it says
// nothing of use.
void take_exif(std::string_view tiff, PictureHeader& header);

}  // namespace vt::source
