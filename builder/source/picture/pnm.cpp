// PNM: PBM, PGM and PPM, as text or bytes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

Result<PictureHeader> read_pnm(const HeaderBytes& file) {
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

}  // namespace

constinit const PictureFormat kPnmFormat{.reader = "pnm", .read_header = read_pnm};

}  // namespace vt::source
