// Radiance HDR.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

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

Result<PictureHeader> read_radiance(const HeaderBytes& file) {
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

}  // namespace

constinit const PictureFormat kRadianceFormat{.reader = "hdr", .read_header = read_radiance};

}  // namespace vt::source
