// What a TIFF claims beyond what its stored bytes can hold is refused before memory or disk space is taken;
// what is merely compressed as much as it can be is read.
#include "builder/source/tiff/compression_bounds.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include "builder/source/cells/block_cache.h"
#include "builder/source/cells/scratch_file.h"
#include "builder/source/files/file_pool.h"
#include "builder/source/raster_source.h"
#include "tests/source/raster_files.h"
#include "tests/support/raw_tiff.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

struct Kind {
  std::uint16_t compression;
  int bits;
};

// One strip of zeros, by libtiff. Returns the bytes that it takes.
std::uint64_t write_zeros(const std::filesystem::path& path, const Kind& kind, std::uint32_t width, std::uint32_t height) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  if (tiff == nullptr) return 0;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, height);
  std::vector<std::uint8_t> zeros((static_cast<std::size_t>(width) * static_cast<std::size_t>(kind.bits) + 7) / 8 * height);
  TIFFWriteEncodedStrip(tiff, 0, zeros.data(), static_cast<tmsize_t>(zeros.size()));
  TIFFClose(tiff);
  TIFF* written = TIFFOpen(path.c_str(), "rc");  // one strip stays one strip
  const std::uint64_t bytes = TIFFGetStrileByteCount(written, 0);
  TIFFClose(written);
  return bytes;
}

TEST(CompressionBounds, NothingIsCompressedMoreThanItsBound) {
  const test::TempFolder folder;
  constexpr std::uint32_t kWidth = 4096;
  constexpr std::uint32_t kHeight = 2048;
  for (const Kind& kind : {Kind{COMPRESSION_NONE, 8},
                           {COMPRESSION_PACKBITS, 8},
                           {COMPRESSION_LZW, 8},
                           {COMPRESSION_ADOBE_DEFLATE, 8},
                           {COMPRESSION_LZMA, 8},
                           {COMPRESSION_ZSTD, 8},
                           {COMPRESSION_JPEG, 8},
                           {COMPRESSION_CCITTRLE, 1},
                           {COMPRESSION_CCITTFAX3, 1},
                           {COMPRESSION_CCITTFAX4, 1}}) {
    SCOPED_TRACE(kind.compression);
    const std::uint64_t bytes = write_zeros(folder / "a.tif", kind, kWidth, kHeight);
    ASSERT_GT(bytes, 0U);
    const std::int64_t row_bytes = kWidth * kind.bits / 8;
    const std::uint64_t least = least_stored_bytes(kind.compression, row_bytes, kHeight);
    EXPECT_LE(least, bytes);
    EXPECT_GT(least, 0U) << "a bound that says nothing protects from nothing";
    const auto source = open_raster(folder / "a.tif");
    ASSERT_TRUE(source.has_value()) << source.error().message;
    EXPECT_EQ(read_all(**source), std::vector<std::byte>(std::size_t{kWidth} * kHeight));
  }
}

// Some files claim by their size alone: 200 bytes as deflate, as zstd and so on.
TEST(CompressionBounds, AStripThatCannotBeSoLargeIsRefusedBeforeItTakesAnything) {
  const test::TempFolder folder;
  for (const std::uint16_t compression :
       {COMPRESSION_PACKBITS, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_LZMA, COMPRESSION_ZSTD}) {
    SCOPED_TRACE(compression);
    test::RawTiff tiff;
    tiff.page({.width = 50000, .height = 50000, .pixels = std::string(200, 'x')}).shorts(259, {compression});
    tiff.write(folder / "a.tif");
    OpenOptions options;
    options.cache = std::make_shared<BlockCache>(std::size_t{1} << 20);
    options.scratch = std::make_shared<ScratchFile>(folder.path());
    const auto source = open_raster(folder / "a.tif", options);
    ASSERT_TRUE(source.has_value()) << source.error().message;
    std::vector<std::byte> out(100);
    const auto read = (*source)->read({0, 40000, 100, 1}, std::vector<int>{0}, out, 100);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
    EXPECT_NE(read.error().message.find("claimed to be in 200 bytes"), std::string::npos) << read.error().message;
    EXPECT_EQ((*source)->decoded_bytes(), 0U);
    EXPECT_EQ(options.scratch->bytes_on_disk(), 0U);
  }
}

// Fax compressions are of one bit and one sample: a writer's slip in either tag makes gigabytes of a few
// pages.
TEST(CompressionBounds, BilevelCompressionsHoldOneBitASample) {
  const test::TempFolder folder;
  for (const std::uint16_t compression : {COMPRESSION_CCITTRLE, COMPRESSION_CCITTFAX3, COMPRESSION_CCITTFAX4}) {
    for (const auto& [bits, samples] : {std::pair{1, 4096}, {8, 1}, {1, 3}}) {
      test::RawTiff tiff = test::RawTiff::grey(16, 16);
      tiff.shorts(259, {compression});
      tiff.shorts(258, std::vector<std::uint16_t>(static_cast<std::size_t>(samples), static_cast<std::uint16_t>(bits)));
      tiff.shorts(277, {static_cast<std::uint16_t>(samples)});
      tiff.write(folder / "a.tif");
      const auto source = open_raster(folder / "a.tif");
      ASSERT_FALSE(source.has_value());
      EXPECT_EQ(source.error().code, ErrorCode::kInvalidData);
      EXPECT_NE(source.error().message.find("holds one sample of one bit"), std::string::npos) << source.error().message;
    }
  }
}

}  // namespace
}  // namespace vt::source
