#include "builder/source/picture/header_bytes.h"

#include <fmt/format.h>

#include <algorithm>

namespace vt::source {
namespace {

// Tag 274 of the first directory of a TIFF stream, as Exif is; 1 when it says nothing of use.
int exif_orientation(std::string_view tiff) {
  if (tiff.size() < 8) return 1;
  const bool is_big = tiff.starts_with("MM");
  const auto number = [&](std::size_t at, std::size_t count) { return is_big ? read_big(tiff, at, count) : read_little(tiff, at, count); };
  if ((!is_big && !tiff.starts_with("II")) || number(2, 2) != 42) return 1;
  const std::size_t directory = number(4, 4);
  if (directory > tiff.size() || tiff.size() - directory < 2) return 1;
  const std::size_t count = number(directory, 2);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    if (tiff.size() < entry + 12) return 1;
    if (number(entry, 2) != 274) continue;
    const auto orientation = static_cast<int>(number(entry + 8, 2));
    return orientation >= 1 && orientation <= 8 ? orientation : 1;
  }
  return 1;
}

}  // namespace

std::uint32_t read_big(std::string_view bytes, std::size_t at, std::size_t count) {
  if (at > bytes.size() || count > bytes.size() - at) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::uint32_t read_little(std::string_view bytes, std::size_t at, std::size_t count) {
  if (at > bytes.size() || count > bytes.size() - at) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

std::uint64_t whole_bytes(double bytes) { return bytes < 1e18 ? static_cast<std::uint64_t>(std::max(0.0, bytes)) : std::uint64_t{1} << 60; }

tl::unexpected<Error> HeaderBytes::damaged(const std::string& what) const {
  return fail(ErrorCode::kInvalidData, file_.path().string() + ": damaged picture: " + what);
}

tl::unexpected<Error> HeaderBytes::unsupported(const std::string& what) const {
  return fail(ErrorCode::kUnsupported, file_.path().string() + ": " + what);
}

Result<Piece> HeaderBytes::part(std::uint64_t at, std::uint64_t bytes) const {
  if (at > size() || bytes > size() - at) return damaged(fmt::format("the file ends inside its header, at byte {}", size()));
  return up_to(at, bytes);
}

Result<Piece> HeaderBytes::up_to(std::uint64_t at, std::uint64_t bytes) const {
  Piece piece(static_cast<std::size_t>(bytes));
  VT_ASSIGN(const std::size_t got, file_.read_some(at, piece.writable()));
  piece.shorten(got);
  return piece;
}

void take_exif(std::string_view tiff, PictureHeader& header) {
  header.orientation = exif_orientation(tiff);
  header.orientation_source = "Orientation in the Exif data (tag 274)";
}

}  // namespace vt::source
