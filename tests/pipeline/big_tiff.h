// A BigTIFF of any nominal size whose tiles were never written: its tables of offsets and sizes are holes in
// the file.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace vt::pipeline {

// `bands` of 8 bits, or one of 32-bit floating point; north-up in EPSG:32633 with its north-west corner at
// (x0, y0).
inline void write_unwritten_tiff(const std::filesystem::path& path, std::uint64_t width, std::uint64_t height, int bands, bool is_float,
                                 double x0, double y0, double step) {
  constexpr std::uint64_t kTile = 256;
  const std::uint64_t tiles = (width + kTile - 1) / kTile * ((height + kTile - 1) / kTile);
  struct Entry {
    std::uint16_t tag, type;
    std::uint64_t count, value;
  };
  std::string extra;  // values that do not fit into their entries
  constexpr std::uint64_t kEntries = 14;
  constexpr std::uint64_t kExtraAt = 16 + 8 + kEntries * 20 + 8;
  const auto put = [&extra](const auto& values) {
    const std::uint64_t at = kExtraAt + extra.size();
    extra.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
    extra.append((8 - extra.size() % 8) % 8, '\0');
    return at;
  };
  const std::uint64_t scale = put(std::vector<double>{step, step, 0.0});
  const std::uint64_t tie = put(std::vector<double>{0.0, 0.0, 0.0, x0, y0, 0.0});
  const std::uint64_t keys = put(std::vector<std::uint16_t>{1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633});
  // Up to four values of two bytes lie in the entry itself.
  std::uint64_t bits = 0;
  std::uint64_t format = 0;
  for (int b = 0; b < bands; ++b) {
    bits |= std::uint64_t{is_float ? 32U : 8U} << 16 * b;
    format |= std::uint64_t{is_float ? 3U : 1U} << 16 * b;
  }
  const std::uint64_t tables = kExtraAt + extra.size();
  const auto count = static_cast<std::uint64_t>(bands);
  const std::vector<Entry> entries{
      {256, 4, 1, width},      {257, 4, 1, height},   {258, 3, count, bits}, {259, 3, 1, 1},           {262, 3, 1, bands == 3 ? 2U : 1U},
      {277, 3, 1, count},      {322, 4, 1, kTile},    {323, 4, 1, kTile},    {324, 16, tiles, tables}, {325, 16, tiles, tables + tiles * 8},
      {339, 3, count, format}, {33550, 12, 3, scale}, {33922, 12, 6, tie},   {34735, 3, 16, keys}};
  ASSERT_EQ(entries.size(), kEntries);
  std::string file;
  const auto number = [&file](const auto value) { file.append(reinterpret_cast<const char*>(&value), sizeof value); };
  file += "II";
  number(std::uint16_t{43});
  number(std::uint16_t{8});
  number(std::uint16_t{0});
  number(std::uint64_t{16});
  number(kEntries);
  for (const Entry& entry : entries) {
    number(entry.tag);
    number(entry.type);
    number(entry.count);
    number(entry.value);
  }
  number(std::uint64_t{0});
  file += extra;
  std::ofstream(path, std::ios::binary) << file;
  std::filesystem::resize_file(path, tables + tiles * 16);
}

}  // namespace vt::pipeline
