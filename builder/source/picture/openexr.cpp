// OpenEXR, scanlines and tiles.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "builder/source/metadata/color_remarks.h"
#include "builder/source/picture/header_bytes.h"
#include "builder/source/picture/picture_format.h"

namespace vt::source {
namespace {

struct Box {
  std::int64_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // inclusive
  [[nodiscard]] std::int64_t width() const { return x1 - x0 + 1; }
  [[nodiscard]] std::int64_t height() const { return y1 - y0 + 1; }
};

Box box_of(std::string_view data) {
  const auto number = [&](std::size_t i) { return static_cast<std::int64_t>(static_cast<std::int32_t>(read_little(data, 4 * i))); };
  return {.x0 = number(0), .y0 = number(1), .x1 = number(2), .y1 = number(3)};
}

struct ExrCompression {
  std::int64_t rows;      // that are compressed together
  double most_inflation;  // samples' bytes from one byte
};
// By number. Runs of 128 bytes from two; deflate; PIZ: 256 16-bit codes from ten bits; PXR24: deflate of
// three bytes that become four; B44: blocks of 32 bytes from three; DWA: deflate of the one code that ends a
// block of 64 half floats.
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
    const std::uint32_t type = read_little(list, name + 1);
    const double sampling =
        std::max(1.0, static_cast<double>(read_little(list, name + 9)) * static_cast<double>(read_little(list, name + 13)));
    attributes.sample_bytes += (type == 1 ? 2.0 : 4.0) / sampling;
    ++attributes.channels;
    list.remove_prefix(name + 17);
  }
}

void read_attribute(std::string_view name, std::string_view data, ExrAttributes& attributes) {
  if (name == "dataWindow" && data.size() >= 16) attributes.data = box_of(data);
  if (name == "displayWindow" && data.size() >= 16) attributes.display = box_of(data);
  if (name == "compression" && !data.empty()) attributes.compression = read_little(data, 0, 1);
  if (name == "tiles" && data.size() >= 8) attributes.tile = {{read_little(data, 0), read_little(data, 4)}};
  if (name == "channels") read_channel_list(data, attributes);
  if (name == "chromaticities" && data.size() >= 32) {
    attributes.chromaticities.emplace();
    for (std::size_t i = 0; i < 8; ++i) (*attributes.chromaticities)[i] = std::bit_cast<float>(read_little(data, 4 * i));
  }
}

Result<ExrAttributes> read_attributes(const HeaderBytes& file) {
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
    const std::uint64_t bytes = read_little(head, type + 1);
    at += type + 5;
    if (bytes > file.size() - at) return file.damaged(fmt::format("an attribute beyond the end of the file at byte {}", at));
    VT_ASSIGN(const Piece data_bytes, file.part(at, std::min<std::uint64_t>(bytes, 1 << 20)));
    const std::string_view data = data_bytes.view();
    read_attribute(head.substr(0, name), data, attributes);
    at += bytes;
  }
  return file.damaged("its header has no end");
}

Result<PictureHeader> read_exr(const HeaderBytes& file) {
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
    // Every piece has its place in a table, 8 bytes; and its samples lie somewhere, unless it was never
    // written.
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
  if ((read_little(start, 4) & kManyParts) != 0) header.unused.push_back({.what = "parts beyond its first"});
  return header;
}

}  // namespace

constinit const PictureFormat kOpenExrFormat{.reader = "openexr", .read_header = read_exr, .has_rows_in_any_order = true};

}  // namespace vt::source
