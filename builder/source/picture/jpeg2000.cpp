// JPEG 2000 (ITU-T T.800), as a file of boxes or a bare codestream.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

using namespace std::string_view_literals;

Result<void> read_codestream(const HeaderBytes& file, std::uint64_t at, PictureHeader& header) {
  VT_ASSIGN(const Piece siz_bytes, file.part(at, 42));
  const std::string_view siz = siz_bytes.view();
  if (read_big(siz, 0) != 0xFF4FFF51) return file.damaged("its codestream does not begin with a SIZ marker");
  const auto number = [&](std::size_t i) { return static_cast<double>(read_big(siz, 8 + 4 * i)); };
  // Reference grid: extent, offset, tile size, tile offset; x before y.
  header.width = static_cast<std::int64_t>(number(0) - number(2));
  header.height = static_cast<std::int64_t>(number(1) - number(3));
  header.channels = static_cast<int>(read_big(siz, 40, 2));
  if (!(number(4) > 0.0) || !(number(5) > 0.0)) return file.damaged("tiles of no size");
  const double tiles = std::ceil((number(0) - number(6)) / number(4)) * std::ceil((number(1) - number(7)) / number(5));
  // A tile has two markers of 14 bytes. What lies in it has no least size: an empty packet is one byte,
  // whatever its area. Of pictures of one colour a byte stands for less than this many samples; what claims
  // more is not believed.
  constexpr double kTileBytes = 14.0;
  constexpr double kSamplesPerByte = 65536.0;
  const double samples = static_cast<double>(header.width) * static_cast<double>(header.height) * header.channels;
  header.least_file_bytes = whole_bytes(std::max(tiles * kTileBytes, samples / kSamplesPerByte));
  // A byte for each component: whether it is signed, and its bits less one.
  VT_ASSIGN(const Piece depths, file.up_to(at + 42, 3 * static_cast<std::size_t>(header.channels)));
  for (std::size_t i = 0; i < depths.view().size(); i += 3) {
    const std::uint32_t depth = read_big(depths.view(), i, 1);
    const std::uint32_t bits = (depth & 0x7F) + 1;
    header.is_signed = header.is_signed || (depth & 0x80) != 0;
    if (bits != 8 && bits != 16) header.expanded_codes = fmt::format("codes of {} bits", bits);
  }
  return {};
}

void read_color_box(std::string_view box, PictureHeader& header) {
  if (box.size() < 3) return;
  const std::uint32_t method = read_big(box, 0, 1);
  if (method == 2 || method == 3) return note_profile(bytes_of(box.substr(3)), header.unused);
  if (method != 1 || box.size() < 7) return;
  const std::uint32_t space = read_big(box, 3);
  constexpr std::uint32_t kInks = 12;
  if (space == kInks) header.unused.push_back(unused_inks());
  if (space != kInks && space != 16 && space != 17 && space != 18)  // sRGB, grey, sYCC
    header.unused.push_back(unused_color(fmt::format("a colour space {} (colr)", space)));
}

// Whether a channel definition box (T.800, I.5.3.6) has a channel of premultiplied opacity: 2, where 1 is
// opacity alone.
bool says_multiplied(std::string_view box) {
  const std::size_t count = box.size() < 2 ? 0 : read_big(box, 0, 2);
  for (std::size_t i = 0; i < count && 2 + 6 * (i + 1) <= box.size(); ++i)
    if (read_big(box, 2 + 6 * i + 2, 2) == 2) return true;
  return false;
}

Result<PictureHeader> read_jpeg2000(const HeaderBytes& file) {
  constexpr std::string_view kGeoJp2 = "\xb1\x4b\xf8\xbd\x08\x3d\x4b\x43\xa5\xae\x8c\xd7\xd5\xa6\xce\x03"sv;
  constexpr std::string_view kExif = "JpgTiffExif->JP2"sv;
  constexpr const char* kPlaceText =
      "its place on the Earth is in a box ({}) that is not read; GDAL makes a GeoTIFF of it: gdal_translate in.jp2 new.tif";
  PictureHeader header{.alpha_is_straight = true};
  bool multiplied_by_alpha = false;
  VT_ASSIGN(const Piece start_bytes, file.part(0, 4));
  const std::string_view start = start_bytes.view();
  if (read_big(start, 0) == 0xFF4FFF51) {
    VT_CHECK(read_codestream(file, 0, header));
    return header;
  }
  std::uint64_t at = 0;
  for (int piece = 0; piece < kMostPieces && at + 8 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece box_head, file.up_to(at, 16));
    const std::string_view head = box_head.view();
    const std::string_view name = head.substr(4, 4);
    std::uint64_t bytes = read_big(head, 0);
    std::uint64_t head_bytes = 8;
    if (bytes == 1 && head.size() == 16) {
      bytes = static_cast<std::uint64_t>(read_big(head, 8)) << 32 | read_big(head, 12);
      head_bytes = 16;
    }
    if (bytes == 0) bytes = file.size() - at;  // the last one
    if (bytes < head_bytes || bytes > file.size() - at) break;
    const auto data = [&] { return file.part(at + head_bytes, std::min(bytes - head_bytes, kMostStoredProfileBytes)); };
    if (name == "jp2h") {  // boxes in a box: go in
      at += head_bytes;
      continue;
    }
    if (name == "colr") {
      VT_ASSIGN(const Piece box_bytes, data());
      const std::string_view box = box_bytes.view();
      read_color_box(box, header);
    } else if (name == "cdef") {
      VT_ASSIGN(const Piece box_bytes, data());
      multiplied_by_alpha = says_multiplied(box_bytes.view());
    } else if (name == "uuid") {
      VT_ASSIGN(const Piece box_bytes, data());
      const std::string_view box = box_bytes.view();
      if (box.starts_with(kGeoJp2)) header.place_problem = fmt::format(kPlaceText, "GeoJP2");
      if (box.starts_with(kExif)) take_exif(box.substr(kExif.size()), header);
    } else if (name == "asoc") {
      VT_ASSIGN(const Piece box_bytes, data());
      const std::string_view box = box_bytes.view();
      if (box.find("gml.data") != std::string::npos) header.place_problem = fmt::format(kPlaceText, "GMLJP2");
    } else if (name == "jp2c") {
      VT_CHECK(read_codestream(file, at + head_bytes, header));
    }
    at += bytes;
  }
  if (header.channels == 0) return file.damaged("no codestream");
  header.alpha_is_straight = !multiplied_by_alpha;
  return header;
}

}  // namespace

constinit const PictureFormat kJpeg2000Format{.reader = "jpeg2000", .read_header = read_jpeg2000};

}  // namespace vt::source
