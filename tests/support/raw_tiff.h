// Classic TIFFs put together tag by tag, little-endian, one uncompressed strip a page: for tests of what tags
// say, with none of the project's own code or libtiff's between the test and the bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vt::test {

class RawTiff {
 public:
  struct Page {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint16_t bits = 8;
    std::uint16_t samples = 1;
    std::uint16_t photometric = 1;    // 0 MinIsWhite, 1 MinIsBlack, 2 RGB, 3 palette, 4 mask
    std::uint16_t sample_format = 1;  // 1 unsigned, 2 signed, 3 floating point
    std::string pixels;               // as they are stored: rows padded to whole bytes
  };

  // Starts a page; tags that follow belong to it.
  RawTiff& page(const Page& page) {
    pages_.push_back({.pixels = page.pixels, .entries = {}});
    longs(256, {page.width});
    longs(257, {page.height});
    shorts(258, std::vector<std::uint16_t>(page.samples, page.bits));
    shorts(259, {1});
    shorts(262, {page.photometric});
    shorts(277, {page.samples});
    longs(278, {page.height});
    longs(279, {static_cast<std::uint32_t>(page.pixels.size())});
    shorts(284, {1});
    shorts(339, std::vector<std::uint16_t>(page.samples, page.sample_format));
    return *this;
  }
  // One page of 8-bit grey samples that are all 64.
  [[nodiscard]] static RawTiff grey(std::uint32_t width, std::uint32_t height) {
    RawTiff tiff;
    tiff.page({.width = width, .height = height, .pixels = std::string(std::size_t{width} * height, '\x40')});
    return tiff;
  }
  RawTiff& shorts(std::uint16_t tag, std::vector<std::uint16_t> values) { return put(tag, 3, values); }
  RawTiff& longs(std::uint16_t tag, std::vector<std::uint32_t> values) { return put(tag, 4, values); }
  RawTiff& doubles(std::uint16_t tag, std::vector<double> values) { return put(tag, 12, values); }
  RawTiff& text(std::uint16_t tag, std::string_view text) {
    std::string bytes(text);
    bytes += '\0';
    pages_.back().entries.push_back({tag, 2, static_cast<std::uint32_t>(bytes.size()), bytes});
    return *this;
  }

  // A tag of one of the types whose values are bytes.
  RawTiff& bytes(std::uint16_t tag, std::uint16_t type, const std::string& bytes) {
    return put(tag, type, std::vector<char>(bytes.begin(), bytes.end()));
  }
  // A projected CRS by its code.
  RawTiff& crs(std::uint16_t epsg) { return shorts(34735, {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, epsg}); }

  // UTM zone 33 north, the upper left corner at (500000, 5000000), `step` metres a sample.
  RawTiff& utm33(double step = 10.0) {
    doubles(33550, {step, step, 0.0});
    doubles(33922, {0.0, 0.0, 0.0, 500000.0, 5000000.0, 0.0});
    return shorts(34735, {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633});
  }

  [[nodiscard]] std::string bytes() const {
    std::string file = std::string("II*\0", 4);
    std::size_t link = file.size();  // where the next directory's place is noted
    file += std::string(4, '\0');
    for (const Directory& page : pages_) {
      std::vector<Entry> entries = page.entries;
      const auto pixels_at = static_cast<std::uint32_t>(file.size());
      if (std::ranges::find(entries, 273, &Entry::tag) == entries.end())
        entries.push_back({273, 4, 1, std::string(reinterpret_cast<const char*>(&pixels_at), 4)});
      std::ranges::sort(entries, {}, &Entry::tag);
      file += page.pixels;
      pad(file);
      std::string table;
      const auto count = static_cast<std::uint16_t>(entries.size());
      table.append(reinterpret_cast<const char*>(&count), 2);
      for (const Entry& entry : entries) {
        table.append(reinterpret_cast<const char*>(&entry.tag), 2);
        table.append(reinterpret_cast<const char*>(&entry.type), 2);
        table.append(reinterpret_cast<const char*>(&entry.count), 4);
        std::string value = entry.bytes;
        if (value.size() > 4) {
          const auto at = static_cast<std::uint32_t>(file.size());
          file += value;
          pad(file);
          value.assign(reinterpret_cast<const char*>(&at), 4);
        }
        value.resize(4, '\0');
        table += value;
      }
      const auto at = static_cast<std::uint32_t>(file.size());
      std::memcpy(file.data() + link, &at, 4);
      file += table;
      link = file.size();
      file += std::string(4, '\0');
    }
    return file;
  }
  void write(const std::filesystem::path& path) const { std::ofstream(path, std::ios::binary) << bytes(); }

 private:
  struct Entry {
    std::uint16_t tag;
    std::uint16_t type;
    std::uint32_t count;
    std::string bytes;
  };
  struct Directory {
    std::string pixels;
    std::vector<Entry> entries;
  };

  template <class T>
  RawTiff& put(std::uint16_t tag, std::uint16_t type, const std::vector<T>& values) {
    std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    std::erase_if(pages_.back().entries, [&](const Entry& entry) { return entry.tag == tag; });
    pages_.back().entries.push_back({tag, type, static_cast<std::uint32_t>(values.size()), std::move(bytes)});
    return *this;
  }
  static void pad(std::string& file) {
    if (file.size() % 2 != 0) file += '\0';
  }

  std::vector<Directory> pages_;
};

// Samples as the bytes of a strip.
template <class T>
[[nodiscard]] std::string pixels_of(const std::vector<T>& samples) {
  return {reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof(T)};
}

}  // namespace vt::test
