// What a source says of its stored content: the same by read() and by hash(), changed where samples changed,
// and only there as far as the file's blocks allow.
#include <gtest/gtest.h>
#include <tiffio.h>

#include <fstream>
#include <random>

#include "builder/source/cells/block_cache.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;
using Compression = GeoTiffSpec::Compression;

constexpr std::int64_t kWidth = 211;
constexpr std::int64_t kHeight = 157;

GeoTiffSpec spec_of(Compression compression, int tile) {
  GeoTiffSpec spec;
  spec.width = kWidth;
  spec.height = kHeight;
  spec.bands = 3;
  spec.compression = compression;
  spec.tile = tile;
  spec.rows_per_strip = 9;
  return spec;
}

store::ContentHash hash_of(const RasterSource& source, const Window& window, const std::vector<int>& bands) {
  store::ContentHasher content;
  const auto done = source.hash(window, bands, content);
  EXPECT_TRUE(done.has_value()) << done.error().message;
  return content.digest();
}

store::ContentHash hash_while_reading(const RasterSource& source, const Window& window, const std::vector<int>& bands) {
  const std::size_t pitch = static_cast<std::size_t>(window.width) * bands.size() * sample_bytes(source.info().sample_type);
  std::vector<std::byte> out(pitch * static_cast<std::size_t>(window.height));
  store::ContentHasher content;
  const auto done = source.read(window, bands, out, pitch, &content);
  EXPECT_TRUE(done.has_value()) << done.error().message;
  return content.digest();
}

TEST(SourceContent, IsTheSameWhetherReadOrOnlyHashed) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kNone, Compression::kDeflate, Compression::kJpeg}) {
    for (const int tile : {0, 64}) {
      SCOPED_TRACE(std::to_string(static_cast<int>(compression)) + " tile " + std::to_string(tile));
      write(folder / "a.tif", spec_of(compression, tile), noise(kWidth * kHeight * 3, 1), 50);
      const auto source = open_raster(folder / "a.tif");
      const auto another = open_raster(folder / "a.tif");
      ASSERT_TRUE(source && another);
      std::mt19937 random(2);
      const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint32_t>(n)); };
      for (int i = 0; i < 40; ++i) {
        Window w{.x = below(kWidth), .y = below(kHeight), .width = 0, .height = 0};
        w.width = 1 + below(kWidth - w.x);
        w.height = 1 + below(kHeight - w.y);
        const std::vector<int> bands = i % 2 == 0 ? std::vector<int>{0, 1, 2} : std::vector<int>{2};
        EXPECT_EQ(hash_of(**source, w, bands), hash_while_reading(**another, w, bands));
        EXPECT_EQ(hash_of(**another, w, bands), hash_while_reading(**source, w, bands));
      }
    }
  }
}

// A sample is changed; windows that hold it must tell, windows far from it must not.
TEST(SourceContent, TellsWhereAFileChanged) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kNone, Compression::kDeflate}) {
    for (const int tile : {0, 16}) {
      auto samples = noise(kWidth * kHeight * 3, 1);
      write(folder / "before.tif", spec_of(compression, tile), samples, 50);
      samples[(100 * kWidth + 100) * 3 + 1] ^= std::byte{1};
      write(folder / "after.tif", spec_of(compression, tile), samples, 50);
      const auto before = open_raster(folder / "before.tif");
      const auto after = open_raster(folder / "after.tif");
      ASSERT_TRUE(before && after);
      for (std::int64_t y = 0; y + 8 <= kHeight; y += 8) {
        for (std::int64_t x = 0; x + 8 <= kWidth; x += 8) {
          const Window w{x, y, 8, 8};
          const bool holds = x <= 100 && 100 < x + 8 && y <= 100 && 100 < y + 8;
          const bool is_far = std::abs(y - 100) > 32;  // two tiles, three strips
          const bool differs = hash_of(**before, w, {0, 1, 2}) != hash_of(**after, w, {0, 1, 2});
          const bool must_not = is_far || (compression == Compression::kNone && !holds);
          EXPECT_TRUE(holds ? differs : !(must_not && differs)) << x << "," << y;
        }
      }
    }
  }
}

// The same stored bytes mean other samples when a table of the directory changes.
TEST(SourceContent, CountsTheTablesThatDecodingNeeds) {
  const TempFolder folder;
  const auto write_palette = [&](const char* name, std::uint16_t green) {
    std::vector<std::uint16_t> ramp(256);
    for (std::size_t i = 0; i < 256; ++i) ramp[i] = static_cast<std::uint16_t>(i * 257);
    std::vector<std::uint16_t> greens = ramp;
    greens[200] = green;
    TIFF* tiff = TIFFOpen((folder / name).c_str(), "w");
    ASSERT_NE(tiff, nullptr);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 16);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_PALETTE);
    TIFFSetField(tiff, TIFFTAG_COLORMAP, ramp.data(), greens.data(), ramp.data());
    std::array<std::uint8_t, 16> row = {200};
    EXPECT_EQ(TIFFWriteScanline(tiff, row.data(), 0, 0), 1);
    TIFFClose(tiff);
  };
  write_palette("a.tif", 1000);
  write_palette("b.tif", 1001);
  write_palette("same.tif", 1000);
  const Window all{0, 0, 16, 1};
  const auto a = hash_of(**open_raster(folder / "a.tif"), all, {0, 1, 2});
  EXPECT_NE(a, hash_of(**open_raster(folder / "b.tif"), all, {0, 1, 2}));
  EXPECT_EQ(a, hash_of(**open_raster(folder / "same.tif"), all, {0, 1, 2}));
}

// Blocks of two sources in one cache are not mistaken for one another.
TEST(SourceContent, SourcesMayShareOneCache) {
  const TempFolder folder;
  OpenOptions options;
  options.cache = std::make_shared<BlockCache>(100000);
  const auto first = noise(kWidth * kHeight * 3, 1);
  const auto second = noise(kWidth * kHeight * 3, 2);
  write(folder / "a.tif", spec_of(Compression::kDeflate, 32), first, 50);
  write(folder / "b.tif", spec_of(Compression::kDeflate, 32), second, 50);
  const auto a = open_raster(folder / "a.tif", options);
  const auto b = open_raster(folder / "b.tif", options);
  ASSERT_TRUE(a && b);
  for (std::uint32_t i = 0; i < 5; ++i) {
    expect_windows_match(**a, first, i, 5);
    expect_windows_match(**b, second, i, 5);
    EXPECT_NE(hash_of(**a, {5, 5, 9, 9}, {0}), hash_of(**b, {5, 5, 9, 9}, {0}));
  }
}

}  // namespace
}  // namespace vt::source
