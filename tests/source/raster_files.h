// Rasters made for a test, and whether a source gives what they hold.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <vector>

#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_writer.h"

namespace vt::source {

inline std::vector<std::byte> noise(std::size_t bytes, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> out(bytes);
  for (std::byte& b : out) b = static_cast<std::byte>(random() % 7 * 31);  // compressible, every bit used somewhere
  return out;
}

inline std::vector<int> all_bands(int count) {
  std::vector<int> bands(static_cast<std::size_t>(count));
  std::iota(bands.begin(), bands.end(), 0);
  return bands;
}

inline void write(const std::filesystem::path& path, const GeoTiffSpec& spec, const std::vector<std::byte>& samples,
                  std::int64_t rows_at_once) {
  auto writer = GeoTiffWriter::create(path, spec);
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  const std::size_t row_bytes =
      static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.bands) * sample_bytes(spec.sample_type);
  for (std::int64_t y = 0; y < spec.height; y += rows_at_once) {
    const std::int64_t rows = std::min(rows_at_once, spec.height - y);
    const auto part = std::span(samples).subspan(static_cast<std::size_t>(y) * row_bytes, static_cast<std::size_t>(rows) * row_bytes);
    const auto written = writer->write_rows(part, rows);
    ASSERT_TRUE(written.has_value()) << written.error().message;
  }
  const auto finished = writer->finish();
  ASSERT_TRUE(finished.has_value()) << finished.error().message;
}

inline std::vector<std::byte> read_all(const RasterSource& source) {
  const RasterInfo& info = source.info();
  const std::size_t pitch = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.bands) * sample_bytes(info.sample_type);
  std::vector<std::byte> out(pitch * static_cast<std::size_t>(info.height));
  const auto read = source.read({0, 0, info.width, info.height}, all_bands(info.bands), out, pitch);
  EXPECT_TRUE(read.has_value()) << read.error().message;
  return out;
}

// Windows of any place and band order give what the whole image has there.
inline void expect_windows_match(const RasterSource& source, const std::vector<std::byte>& whole, std::uint32_t seed, int count) {
  const RasterInfo& info = source.info();
  const std::size_t bytes = sample_bytes(info.sample_type);
  std::mt19937 random(seed);
  for (int i = 0; i < count; ++i) {
    const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint32_t>(n)); };
    Window w{.x = below(info.width), .y = below(info.height), .width = 0, .height = 0};
    w.width = 1 + below(info.width - w.x);
    w.height = 1 + below(std::min<std::int64_t>(info.height - w.y, 200));
    std::vector<int> bands = all_bands(info.bands);
    std::shuffle(bands.begin(), bands.end(), random);
    bands.resize(1 + random() % bands.size());
    const std::size_t row_bytes = static_cast<std::size_t>(w.width) * bands.size() * bytes;
    const std::size_t pitch = row_bytes + random() % 3 * 5;
    std::vector<std::byte> out(pitch * static_cast<std::size_t>(w.height - 1) + row_bytes);
    const auto read = source.read(w, bands, out, pitch);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    for (std::int64_t y = 0; y < w.height; ++y) {
      for (std::int64_t x = 0; x < w.width; ++x) {
        for (std::size_t b = 0; b < bands.size(); ++b) {
          const std::size_t at = static_cast<std::size_t>(((w.y + y) * info.width + w.x + x) * info.bands + bands[b]) * bytes;
          const std::size_t got = static_cast<std::size_t>(y) * pitch + (static_cast<std::size_t>(x) * bands.size() + b) * bytes;
          ASSERT_EQ(std::memcmp(whole.data() + at, out.data() + got, bytes), 0) << x << "," << y << " band " << bands[b];
        }
      }
    }
  }
}

}  // namespace vt::source
