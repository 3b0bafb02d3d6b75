// PNG (ISO/IEC 15948).
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

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
      const auto code = [&](std::size_t i) { return read_big(code_points->view(), i, 1); };
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
    for (std::size_t i = 0; i < xy.size(); ++i) xy[i] = read_big(primaries->view(), 4 * i) / 100000.0;
    note_primaries(xy, "cHRM", unused);
  }
};

Result<PictureHeader> read_png(const HeaderBytes& file) {
  constexpr double kInflation = 1032.0;  // of deflate at most: 258 bytes from two bits
  VT_ASSIGN(const Piece start_bytes, file.part(0, 33));
  const std::string_view start = start_bytes.view();
  if (start.substr(12, 4) != "IHDR") return file.damaged("it does not begin with an IHDR chunk");
  PictureHeader header{.width = read_big(start, 16), .height = read_big(start, 20)};
  const std::uint32_t bits = read_big(start, 24, 1);
  const std::uint32_t type = read_big(start, 25, 1);
  header.channels = type == 2 ? 3 : type == 4 ? 2 : type == 6 ? 4 : 1;
  const double row = 1.0 + std::ceil(static_cast<double>(header.width) * header.channels * bits / 8.0);
  header.least_file_bytes = whole_bytes(static_cast<double>(header.height) * row / kInflation);

  PngColors colors;
  std::uint64_t at = 33;
  for (int piece = 0; piece < kMostPieces && at + 12 <= file.size(); ++piece) {
    VT_ASSIGN(const Piece head_bytes, file.part(at, 8));
    const std::string_view head = head_bytes.view();
    const std::uint64_t bytes = read_big(head, 0);
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
      colors.gamma = read_big(gamma, 0);
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

}  // namespace

constinit const PictureFormat kPngFormat{.reader = "png", .read_header = read_png};

}  // namespace vt::source
