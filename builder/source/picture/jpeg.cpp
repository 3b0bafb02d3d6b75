// JPEG (ITU-T T.81).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

using namespace std::string_view_literals;

// Start of frame: size and components.
Result<void> read_frame(const HeaderBytes& file, int marker, std::string_view frame, PictureHeader& header) {
  if (frame.size() < 6) return file.damaged("its frame header is cut off");
  header.height = read_big(frame, 1, 2);
  header.width = read_big(frame, 3, 2);
  header.channels = static_cast<int>(read_big(frame, 5, 1));
  if (frame.size() < 6 + 3 * static_cast<std::size_t>(header.channels)) return file.damaged("its frame header is cut off");
  std::array<std::uint32_t, 2> most{1, 1};
  const auto sampling = [&](int component) {
    const std::uint32_t both = read_big(frame, 7 + 3 * static_cast<std::size_t>(component), 1);
    return std::array<std::uint32_t, 2>{both >> 4, both & 15};
  };
  for (int c = 0; c < header.channels; ++c)
    for (std::size_t axis = 0; axis < 2; ++axis) most[axis] = std::max(most[axis], sampling(c)[axis]);
  // Every block of 8 x 8 samples has at least one code of one bit, that of its mean; an arithmetic coder may
  // put 64 of them into one.
  double blocks = 0.0;
  for (int c = 0; c < header.channels; ++c)
    blocks += std::ceil(static_cast<double>(header.width) * sampling(c)[0] / most[0] / 8) *
              std::ceil(static_cast<double>(header.height) * sampling(c)[1] / most[1] / 8);
  const bool is_arithmetic = marker >= 0xC9;
  header.least_file_bytes = whole_bytes(blocks / 8 / (is_arithmetic ? 64 : 1));
  return {};
}

Result<PictureHeader> read_jpeg(const HeaderBytes& file) {
  PictureHeader header;
  std::string profile;
  std::uint64_t at = 2;
  for (int piece = 0; piece < kMostPieces && at + 4 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece head_bytes, file.part(at, 4));
    const std::string_view head = head_bytes.view();
    const int marker = static_cast<int>(read_big(head, 1, 1));
    if (read_big(head, 0, 1) != 0xFF) return file.damaged(fmt::format("no marker at byte {}", at));
    if (marker == 0xFF || marker == 0x01 || (marker >= 0xD0 && marker <= 0xD7)) {  // fill bytes and markers without data
      at += marker == 0xFF ? 1 : 2;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA) break;  // the end, or the first scan
    const std::uint64_t bytes = read_big(head, 2, 2);
    if (bytes < 2) return file.damaged(fmt::format("a segment of no length at byte {}", at));
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame || marker == 0xE1 || marker == 0xE2) {
      VT_ASSIGN(const Piece data_bytes, file.part(at + 4, bytes - 2));
      const std::string_view data = data_bytes.view();
      if (is_frame) VT_CHECK(read_frame(file, marker, data, header));
      if (marker == 0xE1 && data.starts_with("Exif\0\0"sv)) take_exif(data.substr(6), header);
      if (marker == 0xE2 && data.starts_with("ICC_PROFILE\0"sv) && data.size() > 14 && profile.size() < kMostStoredProfileBytes)
        profile += data.substr(14);  // in order
    }
    at += 2 + bytes;
  }
  if (header.channels == 0) return file.damaged("no frame header before the first scan");
  if (header.channels == 4) header.unused.push_back(unused_inks());
  if (!profile.empty()) note_profile(bytes_of(profile), header.unused);
  return header;
}

}  // namespace

constinit const PictureFormat kJpegFormat{.reader = "jpeg", .read_header = read_jpeg};

}  // namespace vt::source
