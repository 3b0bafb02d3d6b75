#include "builder/source/picture/picture_header.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>

#include "builder/source/metadata/color_remarks.h"

namespace vt::source {
namespace {

using namespace std::string_view_literals;

// Pieces of a file that a header may be made of: hostile files have many, of no use.
constexpr int kMostPieces = 1 << 17;
constexpr std::uint64_t kMostStoredProfileBytes = std::uint64_t{4} << 20;

// Numbers of one to four bytes; 0 where the text ends before them.
std::uint32_t big(std::string_view bytes, std::size_t at, std::size_t count = 4) {
  if (at > bytes.size() || count > bytes.size() - at) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::uint32_t little(std::string_view bytes, std::size_t at, std::size_t count = 4) {
  if (at > bytes.size() || count > bytes.size() - at) return 0;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

// Of a size in bytes that may exceed every integer, or be none.
std::uint64_t whole_bytes(double bytes) { return bytes < 1e18 ? static_cast<std::uint64_t>(std::max(0.0, bytes)) : std::uint64_t{1} << 60; }

// Some bytes of a file. Not a string: those keep short texts inside, which GCC 12 takes for uninitialised memory here.
class Piece {
 public:
  explicit Piece(std::size_t bytes) : bytes_(bytes) {}
  [[nodiscard]] std::span<std::byte> writable() { return std::as_writable_bytes(std::span(bytes_)); }
  void shorten(std::size_t bytes) { bytes_.resize(bytes); }
  [[nodiscard]] std::string_view view() const { return {bytes_.data(), bytes_.size()}; }

 private:
  std::vector<char> bytes_;
};

class Header {
 public:
  explicit Header(const FileBytes& file) : file_(file) {}

  [[nodiscard]] std::uint64_t size() const { return file_.size(); }
  [[nodiscard]] tl::unexpected<Error> damaged(const std::string& what) const {
    return fail(ErrorCode::kInvalidData, file_.path().string() + ": damaged picture: " + what);
  }
  [[nodiscard]] tl::unexpected<Error> unsupported(const std::string& what) const {
    return fail(ErrorCode::kUnsupported, file_.path().string() + ": " + what);
  }
  // Exactly so many bytes.
  [[nodiscard]] Result<Piece> part(std::uint64_t at, std::uint64_t bytes) const {
    if (at > size() || bytes > size() - at) return damaged(fmt::format("the file ends inside its header, at byte {}", size()));
    return up_to(at, bytes);
  }
  // Fewer at the end of the file.
  [[nodiscard]] Result<Piece> up_to(std::uint64_t at, std::uint64_t bytes) const {
    Piece piece(static_cast<std::size_t>(bytes));
    VT_ASSIGN(const std::size_t got, file_.read_some(at, piece.writable()));
    piece.shorten(got);
    return piece;
  }

 private:
  const FileBytes& file_;
};

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

// Tag 274 of the first directory of a TIFF stream, as Exif is; 1 when it says nothing of use.
int exif_orientation(std::string_view tiff) {
  if (tiff.size() < 8) return 1;
  const bool is_big = tiff.starts_with("MM");
  const auto number = [&](std::size_t at, std::size_t count) { return is_big ? big(tiff, at, count) : little(tiff, at, count); };
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

void take_exif(std::string_view tiff, PictureHeader& header) {
  header.orientation = exif_orientation(tiff);
  header.orientation_source = "Orientation in the Exif data (tag 274)";
}

// PNG (ISO/IEC 15948).

// An iCCP chunk: a name, a zero, the method 0, a zlib stream.
std::string inflated_profile(std::string_view chunk) {
  const std::size_t name = chunk.find('\0');
  if (name == std::string_view::npos || name + 2 > chunk.size()) return {};
  const std::string_view packed = chunk.substr(name + 2);
  std::string profile(static_cast<std::size_t>(kMostStoredProfileBytes), '\0');
  uLongf bytes = profile.size();
  if (::uncompress(reinterpret_cast<Bytef*>(profile.data()), &bytes, reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK)
    return {};
  profile.resize(bytes);
  return profile;
}

// What a PNG says of its colours; of several the first of this list counts.
struct PngColors {
  std::optional<Piece> code_points;    // cICP
  std::optional<Piece> profile;        // iCCP, still packed
  bool is_srgb = false;                // sRGB
  std::optional<std::uint32_t> gamma;  // gAMA, times 100000
  std::optional<Piece> primaries;      // cHRM

  void note(std::vector<UnusedFact>& unused) const {
    if (code_points) {
      const auto code = [&](std::size_t i) { return big(code_points->view(), i, 1); };
      if (code(0) != 1 || code(1) != 13) unused.push_back(unused_color(fmt::format("a colour space {}, {} (cICP)", code(0), code(1))));
      return;
    }
    if (profile) return note_profile(bytes_of(inflated_profile(profile->view())), unused);
    if (is_srgb) return;
    // 1 / 2.2 is what files say that mean sRGB.
    constexpr std::uint32_t kUsual = 45455;
    constexpr std::uint32_t kTolerance = 500;
    if (gamma && (*gamma < kUsual - kTolerance || *gamma > kUsual + kTolerance))
      unused.push_back(unused_color(fmt::format("a gamma of {:.5g} (gAMA)", *gamma / 100000.0)));
    if (!primaries) return;
    std::array<double, 8> xy{};
    for (std::size_t i = 0; i < xy.size(); ++i) xy[i] = big(primaries->view(), 4 * i) / 100000.0;
    note_primaries(xy, "cHRM", unused);
  }
};

Result<PictureHeader> read_png(const Header& file) {
  constexpr double kInflation = 1032.0;  // of deflate at most: 258 bytes from two bits
  VT_ASSIGN(const Piece start_bytes, file.part(0, 33));
  const std::string_view start = start_bytes.view();
  if (start.substr(12, 4) != "IHDR") return file.damaged("it does not begin with an IHDR chunk");
  PictureHeader header{.width = big(start, 16), .height = big(start, 20)};
  const std::uint32_t bits = big(start, 24, 1);
  const std::uint32_t type = big(start, 25, 1);
  header.channels = type == 2 ? 3 : type == 4 ? 2 : type == 6 ? 4 : 1;
  const double row = 1.0 + std::ceil(static_cast<double>(header.width) * header.channels * bits / 8.0);
  header.least_file_bytes = whole_bytes(static_cast<double>(header.height) * row / kInflation);

  PngColors colors;
  std::uint64_t at = 33;
  for (int piece = 0; piece < kMostPieces && at + 12 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece head_bytes, file.part(at, 8));
    const std::string_view head = head_bytes.view();
    const std::uint64_t bytes = big(head, 0);
    const std::string_view name = head.substr(4);
    if (name == "IEND" || bytes > file.size() - at - 12) break;  // the decoder tells of a file that is cut off
    const auto data = [&] { return file.part(at + 8, std::min(bytes, kMostStoredProfileBytes)); };
    if (name == "cICP" && bytes == 4) {
      VT_ASSIGN(colors.code_points, data());
    } else if (name == "iCCP") {
      VT_ASSIGN(colors.profile, data());
    } else if (name == "sRGB") {
      colors.is_srgb = true;
    } else if (name == "gAMA" && bytes == 4) {
      VT_ASSIGN(const Piece gamma_bytes, data());
      const std::string_view gamma = gamma_bytes.view();
      colors.gamma = big(gamma, 0);
    } else if (name == "cHRM" && bytes == 32) {
      VT_ASSIGN(colors.primaries, data());
    } else if (name == "eXIf") {
      VT_ASSIGN(const Piece exif_bytes, data());
      const std::string_view exif = exif_bytes.view();
      take_exif(exif, header);
    }
    at += 12 + bytes;
  }
  colors.note(header.unused);
  return header;
}

// JPEG (ITU-T T.81).

// Start of frame: size and components.
Result<void> read_frame(const Header& file, int marker, std::string_view frame, PictureHeader& header) {
  if (frame.size() < 6) return file.damaged("its frame header is cut off");
  header.height = big(frame, 1, 2);
  header.width = big(frame, 3, 2);
  header.channels = static_cast<int>(big(frame, 5, 1));
  if (frame.size() < 6 + 3 * static_cast<std::size_t>(header.channels)) return file.damaged("its frame header is cut off");
  std::array<std::uint32_t, 2> most{1, 1};
  const auto sampling = [&](int component) {
    const std::uint32_t both = big(frame, 7 + 3 * static_cast<std::size_t>(component), 1);
    return std::array<std::uint32_t, 2>{both >> 4, both & 15};
  };
  for (int c = 0; c < header.channels; ++c)
    for (std::size_t axis = 0; axis < 2; ++axis) most[axis] = std::max(most[axis], sampling(c)[axis]);
  // Every block of 8 x 8 samples has at least one code of one bit, that of its mean; an arithmetic coder may put 64 of them into one.
  double blocks = 0.0;
  for (int c = 0; c < header.channels; ++c)
    blocks += std::ceil(static_cast<double>(header.width) * sampling(c)[0] / most[0] / 8) *
              std::ceil(static_cast<double>(header.height) * sampling(c)[1] / most[1] / 8);
  const bool is_arithmetic = marker >= 0xC9;
  header.least_file_bytes = whole_bytes(blocks / 8 / (is_arithmetic ? 64 : 1));
  return {};
}

Result<PictureHeader> read_jpeg(const Header& file) {
  PictureHeader header;
  std::string profile;
  std::uint64_t at = 2;
  for (int piece = 0; piece < kMostPieces && at + 4 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece head_bytes, file.part(at, 4));
    const std::string_view head = head_bytes.view();
    const int marker = static_cast<int>(big(head, 1, 1));
    if (big(head, 0, 1) != 0xFF) return file.damaged(fmt::format("no marker at byte {}", at));
    if (marker == 0xFF || marker == 0x01 || (marker >= 0xD0 && marker <= 0xD7)) {  // fill bytes and markers without data
      at += marker == 0xFF ? 1 : 2;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA) break;  // the end, or the first scan
    const std::uint64_t bytes = big(head, 2, 2);
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

// JPEG 2000 (ITU-T T.800), as a file of boxes or a bare codestream.

Result<void> read_codestream(const Header& file, std::uint64_t at, PictureHeader& header) {
  VT_ASSIGN(const Piece siz_bytes, file.part(at, 42));
  const std::string_view siz = siz_bytes.view();
  if (big(siz, 0) != 0xFF4FFF51) return file.damaged("its codestream does not begin with a SIZ marker");
  const auto number = [&](std::size_t i) { return static_cast<double>(big(siz, 8 + 4 * i)); };
  // Reference grid: extent, offset, tile size, tile offset; x before y.
  header.width = static_cast<std::int64_t>(number(0) - number(2));
  header.height = static_cast<std::int64_t>(number(1) - number(3));
  header.channels = static_cast<int>(big(siz, 40, 2));
  if (!(number(4) > 0.0) || !(number(5) > 0.0)) return file.damaged("tiles of no size");
  const double tiles = std::ceil((number(0) - number(6)) / number(4)) * std::ceil((number(1) - number(7)) / number(5));
  // A tile has two markers of 14 bytes. What lies in it has no least size: an empty packet is one byte, whatever its area. Of pictures of
  // one colour a byte stands for less than this many samples; what claims more is not believed.
  constexpr double kTileBytes = 14.0;
  constexpr double kSamplesPerByte = 65536.0;
  const double samples = static_cast<double>(header.width) * static_cast<double>(header.height) * header.channels;
  header.least_file_bytes = whole_bytes(std::max(tiles * kTileBytes, samples / kSamplesPerByte));
  // A byte for each component: whether it is signed, and its bits less one.
  VT_ASSIGN(const Piece depths, file.up_to(at + 42, 3 * static_cast<std::size_t>(header.channels)));
  for (std::size_t i = 0; i < depths.view().size(); i += 3) {
    const std::uint32_t depth = big(depths.view(), i, 1);
    const std::uint32_t bits = (depth & 0x7F) + 1;
    header.is_signed = header.is_signed || (depth & 0x80) != 0;
    if (bits != 8 && bits != 16) header.expanded_codes = fmt::format("codes of {} bits", bits);
  }
  return {};
}

void read_color_box(std::string_view box, PictureHeader& header) {
  if (box.size() < 3) return;
  const std::uint32_t method = big(box, 0, 1);
  if (method == 2 || method == 3) return note_profile(bytes_of(box.substr(3)), header.unused);
  if (method != 1 || box.size() < 7) return;
  const std::uint32_t space = big(box, 3);
  constexpr std::uint32_t kInks = 12;
  if (space == kInks) header.unused.push_back(unused_inks());
  if (space != kInks && space != 16 && space != 17 && space != 18)  // sRGB, grey, sYCC
    header.unused.push_back(unused_color(fmt::format("a colour space {} (colr)", space)));
}

// Whether a channel definition box (T.800, I.5.3.6) has a channel of premultiplied opacity: 2, where 1 is opacity alone.
bool says_multiplied(std::string_view box) {
  const std::size_t count = box.size() < 2 ? 0 : big(box, 0, 2);
  for (std::size_t i = 0; i < count && 2 + 6 * (i + 1) <= box.size(); ++i)
    if (big(box, 2 + 6 * i + 2, 2) == 2) return true;
  return false;
}

Result<PictureHeader> read_jpeg2000(const Header& file) {
  constexpr std::string_view kGeoJp2 = "\xb1\x4b\xf8\xbd\x08\x3d\x4b\x43\xa5\xae\x8c\xd7\xd5\xa6\xce\x03"sv;
  constexpr std::string_view kExif = "JpgTiffExif->JP2"sv;
  constexpr const char* kPlaceText =
      "its place on the Earth is in a box ({}) that is not read; GDAL makes a GeoTIFF of it: gdal_translate in.jp2 new.tif";
  PictureHeader header{.alpha_is_straight = true};
  bool multiplied_by_alpha = false;
  VT_ASSIGN(const Piece start_bytes, file.part(0, 4));
  const std::string_view start = start_bytes.view();
  if (big(start, 0) == 0xFF4FFF51) {
    VT_CHECK(read_codestream(file, 0, header));
    return header;
  }
  std::uint64_t at = 0;
  for (int piece = 0; piece < kMostPieces && at + 8 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece box_head, file.up_to(at, 16));
    const std::string_view head = box_head.view();
    const std::string_view name = head.substr(4, 4);
    std::uint64_t bytes = big(head, 0);
    std::uint64_t head_bytes = 8;
    if (bytes == 1 && head.size() == 16) {
      bytes = static_cast<std::uint64_t>(big(head, 8)) << 32 | big(head, 12);
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

// OpenEXR.

struct Box {
  std::int64_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // inclusive
  [[nodiscard]] std::int64_t width() const { return x1 - x0 + 1; }
  [[nodiscard]] std::int64_t height() const { return y1 - y0 + 1; }
};

Box box_of(std::string_view data) {
  const auto number = [&](std::size_t i) { return static_cast<std::int64_t>(static_cast<std::int32_t>(little(data, 4 * i))); };
  return {.x0 = number(0), .y0 = number(1), .x1 = number(2), .y1 = number(3)};
}

struct ExrCompression {
  std::int64_t rows;      // that are compressed together
  double most_inflation;  // samples' bytes from one byte
};
// By number. Runs of 128 bytes from two; deflate; PIZ: 256 16-bit codes from ten bits; PXR24: deflate of three bytes that become four; B44:
// blocks of 32 bytes from three; DWA: deflate of the one code that ends a block of 64 half floats.
constexpr std::array<ExrCompression, 10> kExrCompressions = {
    {{1, 1.0}, {1, 64.0}, {1, 1032.0}, {16, 1032.0}, {32, 512.0}, {16, 1376.0}, {32, 11.0}, {32, 11.0}, {32, 66048.0}, {256, 66048.0}}};

struct ExrAttributes {
  std::optional<Box> data;
  std::optional<Box> display;
  std::uint32_t compression = 0;
  std::optional<std::array<std::int64_t, 2>> tile;
  std::optional<std::array<double, 8>> chromaticities;  // red, green, blue, white
  double sample_bytes = 0.0;                            // of one place, all channels
  int channels = 0;
};

void read_channel_list(std::string_view list, ExrAttributes& attributes) {
  while (!list.empty() && list.front() != '\0') {
    const std::size_t name = list.find('\0');
    if (name == std::string_view::npos || list.size() < name + 17) return;
    const std::uint32_t type = little(list, name + 1);
    const double sampling = std::max(1.0, static_cast<double>(little(list, name + 9)) * static_cast<double>(little(list, name + 13)));
    attributes.sample_bytes += (type == 1 ? 2.0 : 4.0) / sampling;
    ++attributes.channels;
    list.remove_prefix(name + 17);
  }
}

void read_attribute(std::string_view name, std::string_view data, ExrAttributes& attributes) {
  if (name == "dataWindow" && data.size() >= 16) attributes.data = box_of(data);
  if (name == "displayWindow" && data.size() >= 16) attributes.display = box_of(data);
  if (name == "compression" && !data.empty()) attributes.compression = little(data, 0, 1);
  if (name == "tiles" && data.size() >= 8) attributes.tile = {{little(data, 0), little(data, 4)}};
  if (name == "channels") read_channel_list(data, attributes);
  if (name == "chromaticities" && data.size() >= 32) {
    attributes.chromaticities.emplace();
    for (std::size_t i = 0; i < 8; ++i) (*attributes.chromaticities)[i] = std::bit_cast<float>(little(data, 4 * i));
  }
}

Result<ExrAttributes> read_attributes(const Header& file) {
  ExrAttributes attributes;
  std::uint64_t at = 8;
  for (int piece = 0; piece < kMostPieces; ++piece) {
    VT_ASSIGN(const Piece head_bytes, file.up_to(at, 520));
    const std::string_view head = head_bytes.view();  // two names of at most 255 characters, and a length
    if (head.empty()) return file.damaged("its header has no end");
    if (head.front() == '\0') return attributes;
    const std::size_t name = head.find('\0');
    const std::size_t type = name == std::string::npos ? name : head.find('\0', name + 1);
    if (type == std::string::npos || head.size() < type + 5) return file.damaged(fmt::format("an attribute without end at byte {}", at));
    const std::uint64_t bytes = little(head, type + 1);
    at += type + 5;
    if (bytes > file.size() - at) return file.damaged(fmt::format("an attribute beyond the end of the file at byte {}", at));
    VT_ASSIGN(const Piece data_bytes, file.part(at, std::min<std::uint64_t>(bytes, 1 << 20)));
    const std::string_view data = data_bytes.view();
    read_attribute(head.substr(0, name), data, attributes);
    at += bytes;
  }
  return file.damaged("its header has no end");
}

Result<PictureHeader> read_exr(const Header& file) {
  constexpr std::uint32_t kManyParts = 0x1000;
  VT_ASSIGN(const Piece start_bytes, file.part(0, 8));
  const std::string_view start = start_bytes.view();
  VT_ASSIGN(const ExrAttributes exr, read_attributes(file));
  if (!exr.data || exr.channels == 0) return file.damaged("its header names no channels or no data window");
  PictureHeader header{.width = exr.data->width(), .height = exr.data->height(), .channels = exr.channels};
  if (header.width < 1 || header.height < 1) return file.damaged(fmt::format("a data window of {} x {}", header.width, header.height));

  if (exr.compression < kExrCompressions.size()) {
    const ExrCompression& compression = kExrCompressions[exr.compression];
    const auto width = static_cast<double>(header.width);
    const auto height = static_cast<double>(header.height);
    const bool is_tiled = exr.tile && (*exr.tile)[0] > 0 && (*exr.tile)[1] > 0;
    const double pieces =
        is_tiled ? std::ceil(width / static_cast<double>((*exr.tile)[0])) * std::ceil(height / static_cast<double>((*exr.tile)[1]))
                 : std::ceil(height / static_cast<double>(compression.rows));
    // Every piece has its place in a table, 8 bytes; and its samples lie somewhere, unless it was never written.
    const double samples = is_tiled ? 0.0 : width * height * exr.sample_bytes / compression.most_inflation;
    header.least_file_bytes = whole_bytes(std::max(8.0 * pieces, samples));
  }
  if (exr.display && (exr.display->x0 != exr.data->x0 || exr.display->y0 != exr.data->y0 || exr.display->x1 != exr.data->x1 ||
                      exr.display->y1 != exr.data->y1)) {
    if (exr.display->width() < 1 || exr.display->height() < 1)
      return file.damaged(fmt::format("a display window of {} x {}", exr.display->width(), exr.display->height()));
    header.display = Window{.x = exr.display->x0 - exr.data->x0,
                            .y = exr.display->y0 - exr.data->y0,
                            .width = exr.display->width(),
                            .height = exr.display->height()};
  }
  if (exr.chromaticities) {
    const std::array<double, 8>& c = *exr.chromaticities;
    note_primaries({c[6], c[7], c[0], c[1], c[2], c[3], c[4], c[5]}, "chromaticities", header.unused);
  }
  if ((little(start, 4) & kManyParts) != 0) header.unused.push_back({.what = "parts beyond its first"});
  return header;
}

// Radiance HDR.

// A number without anything behind it.
template <class T>
std::optional<T> number_of(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

// "-Y 480 +X 640": which way rows and columns run, and how many there are.
bool read_resolution(std::string_view line, PictureHeader& header) {
  std::array<std::string_view, 4> words;
  for (std::string_view& word : words) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    line.remove_prefix(begin);
    word = line.substr(0, line.find_first_of(" \r"));
    line.remove_prefix(word.size());
  }
  const auto first = number_of<std::int32_t>(words[1]);
  const auto second = number_of<std::int32_t>(words[3]);
  if (!first || !second || words[0].size() != 2 || words[2].size() != 2) return false;
  const bool is_by_rows = words[0][1] == 'Y';
  header.height = is_by_rows ? *first : *second;
  header.width = is_by_rows ? *second : *first;
  header.orientation = words[0] == "-Y" && words[2] == "+X" ? 1 : words[0] == "+Y" && words[2] == "+X" ? 4 : is_by_rows ? 2 : 5;
  header.orientation_source = fmt::format("the resolution line \"{} ... {} ...\"", words[0], words[2]);
  return true;
}

Result<PictureHeader> read_radiance(const Header& file) {
  constexpr std::uint64_t kMostHeaderBytes = 1 << 16;
  constexpr double kPixelsPerByte = 16.0;  // runs of 127 in each of four planes take two bytes
  VT_ASSIGN(const Piece head_bytes, file.up_to(0, kMostHeaderBytes));
  const std::string_view head = head_bytes.view();
  PictureHeader header{.channels = 3};
  double exposure = 1.0;
  for (std::size_t at = 0; at < head.size();) {
    const std::size_t end = head.find('\n', at);
    if (end == std::string::npos) break;
    const std::string_view line = head.substr(at, end - at);
    at = end + 1;
    if (line.starts_with("EXPOSURE=")) exposure *= number_of<double>(line.substr(9)).value_or(1.0);
    if (line.starts_with("PRIMARIES=")) header.unused.push_back(unused_color("primaries of its own (PRIMARIES)"));
    if (line.starts_with("COLORCORR=")) header.unused.push_back(unused_color("a colour correction (COLORCORR)"));
    if (line.starts_with("FORMAT=32-bit_rle_xyze"))
      return file.unsupported("its colours are CIE X, Y and Z (FORMAT=32-bit_rle_xyze); wanted red, green and blue");
    if (!line.empty() && line != "\r") continue;
    const std::string_view resolution = head.substr(at, head.find('\n', at) - at);
    if (!read_resolution(resolution, header)) return file.damaged("its header ends without a resolution");
    if (exposure != 1.0)
      header.unused.push_back(
          {.what = fmt::format("an EXPOSURE of {:.6g}", exposure), .instead = "values are as stored, that many times the radiance"});
    header.least_file_bytes = whole_bytes(static_cast<double>(header.width) * static_cast<double>(header.height) / kPixelsPerByte);
    return header;
  }
  return file.damaged("its header has no end");
}

// PNM.

Result<PictureHeader> read_pnm(const Header& file) {
  VT_ASSIGN(const Piece head_bytes, file.up_to(0, 4096));
  const std::string_view head = head_bytes.view();
  const char kind = head[1];
  std::size_t at = 2;
  std::array<std::int64_t, 3> numbers{0, 0, 1};  // width, height, greatest code
  const bool is_bitmap = kind == '1' || kind == '4';
  for (std::size_t i = 0; i < (is_bitmap ? 2U : 3U); ++i) {
    while (at < head.size() && (std::isspace(static_cast<unsigned char>(head[at])) != 0 || head[at] == '#')) {
      if (head[at] == '#') at = std::min(head.find('\n', at), head.size());
      if (at < head.size()) ++at;
    }
    const std::size_t end = std::min(head.find_first_not_of("0123456789", at), head.size());
    const auto number = number_of<std::int64_t>(head.substr(at, end - at));
    if (!number || *number < 1 || *number > 0x7FFFFFFF) return file.damaged("its header does not say how large it is");
    numbers[i] = *number;
    at = end;
  }
  PictureHeader header{.width = numbers[0], .height = numbers[1], .channels = kind == '3' || kind == '6' ? 3 : 1};
  const auto width = static_cast<double>(header.width);
  const auto height = static_cast<double>(header.height);
  const double samples = width * height * header.channels;
  const double bytes = kind == '4'   ? std::ceil(width / 8) * height
                       : kind == '1' ? samples          // a digit each
                       : kind <= '3' ? 2 * samples - 1  // and white space between
                                     : samples * (numbers[2] > 255 ? 2 : 1);
  header.least_file_bytes = whole_bytes(bytes);
  if (is_bitmap) header.expanded_codes = "codes of 1 bit";
  if (!is_bitmap && numbers[2] != 255 && numbers[2] != 65535) header.expanded_codes = fmt::format("codes of 0 to {}", numbers[2]);
  return header;
}

Result<PictureHeader> read_header(const Header& file, RasterFormat format) {
  switch (format) {
    case RasterFormat::kPng:
      return read_png(file);
    case RasterFormat::kJpeg:
      return read_jpeg(file);
    case RasterFormat::kJpeg2000:
      return read_jpeg2000(file);
    case RasterFormat::kOpenExr:
      return read_exr(file);
    case RasterFormat::kRadiance:
      return read_radiance(file);
    case RasterFormat::kPnm:
      return read_pnm(file);
    case RasterFormat::kTiff:
      break;
  }
  return fail(ErrorCode::kInternal, "a TIFF is no picture here");
}

}  // namespace

Result<PictureHeader> read_picture_header(const FileBytes& file, RasterFormat format) {
  VT_ASSIGN(PictureHeader header, read_header(Header(file), format));
  if (header.width < 1 || header.height < 1)
    return fail(ErrorCode::kInvalidData, fmt::format("{}: claims to be a picture of {} x {}, which is none; the file is damaged",
                                                     file.path().string(), header.width, header.height));
  if (header.least_file_bytes > file.size())
    return fail(
        ErrorCode::kInvalidData,
        fmt::format("{}: claims to be a picture of {} x {} with {} channels, which takes at least {} bytes in this format; the file has "
                    "{} and is damaged or incomplete",
                    file.path().string(), header.width, header.height, header.channels, header.least_file_bytes, file.size()));
  return header;
}

}  // namespace vt::source
