// Strips unpacked a little at a time are what libtiff makes of them, and damage never ends in wrong rows
// without an error.
#include "builder/source/tiff/strip_stream.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "builder/source/metadata/tiff_tags.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;

struct StripFile {
  std::uint16_t compression = COMPRESSION_LZW;
  std::uint16_t predictor = PREDICTOR_NONE;
  std::uint16_t bits = 8;
  std::uint16_t samples = 1;
  bool is_float = false;
  bool is_big_endian = false;
  std::uint32_t width = 97;
  std::uint32_t height = 300;
  std::uint32_t rows_per_strip = 300;
};

std::size_t row_bytes(const StripFile& kind) { return (std::size_t{kind.width} * kind.samples * kind.bits + 7) / 8; }

// Smooth with some noise: what makes every code width and word length of LZW occur.
std::vector<std::byte> samples_of(const StripFile& kind) {
  std::mt19937 random(kind.bits + kind.samples);
  std::vector<std::byte> samples(row_bytes(kind) * kind.height);
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i] = static_cast<std::byte>(i / 50 + (i % 3000 < 2000 ? random() % 5 * (random() % 3 == 0 ? 1 : 0) : 0));
  return samples;
}

void write_strips(const std::filesystem::path& path, const StripFile& kind, std::vector<std::byte> samples) {
  TIFF* tiff = TIFFOpen(path.c_str(), kind.is_big_endian ? "wb" : "wl");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kind.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kind.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind.is_float ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.samples == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kind.rows_per_strip);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  if (kind.predictor != PREDICTOR_NONE) TIFFSetField(tiff, TIFFTAG_PREDICTOR, kind.predictor);
  const std::size_t strip_bytes = row_bytes(kind) * kind.rows_per_strip;
  for (std::uint32_t strip = 0; strip * strip_bytes < samples.size(); ++strip) {
    const std::size_t bytes = std::min(strip_bytes, samples.size() - strip * strip_bytes);
    ASSERT_GE(TIFFWriteEncodedStrip(tiff, strip, samples.data() + strip * strip_bytes, static_cast<tmsize_t>(bytes)), 0);
  }
  TIFFClose(tiff);
}

struct OpenStrip {
  std::shared_ptr<const FileBytes> file;
  TiffLayout layout;
  StripStream::Strip strip;
};

// The last strip of the file.
Result<OpenStrip> open_strip(const std::filesystem::path& path) {
  OpenStrip open;
  VT_ASSIGN(open.file, FileBytes::open(path));
  VT_ASSIGN(const auto handle, TiffHandle::open(open.file));
  VT_ASSIGN(const TiffTags tags, TiffTags::read(open.file, TIFFCurrentDirOffset(handle->get())));
  VT_ASSIGN(open.layout, read_tiff_layout(*handle, tags, "strip", {}, {}));
  const auto last = static_cast<std::uint32_t>(open.layout.blocks_down - 1);
  open.strip = {.offset = TIFFGetStrileOffset(handle->get(), last),
                .bytes = TIFFGetStrileByteCount(handle->get(), last),
                .first_row = last * open.layout.block_height};
  return open;
}

TEST(StripStream, GivesTheRowsThatLibtiffGives) {
  const TempFolder folder;
  int count = 0;
  for (const std::uint16_t compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
    for (const std::uint16_t predictor : {PREDICTOR_NONE, PREDICTOR_HORIZONTAL, PREDICTOR_FLOATINGPOINT}) {
      for (const std::uint16_t bits : {1, 8, 12, 16, 24, 32, 64}) {
        for (const std::uint16_t samples : {1, 3}) {
          for (const bool is_big_endian : {false, true}) {
            StripFile kind{.compression = compression, .predictor = predictor, .bits = bits, .samples = samples};
            kind.is_big_endian = is_big_endian;
            kind.is_float = bits == 64 || predictor == PREDICTOR_FLOATINGPOINT;
            const bool whole_words = bits == 8 || bits == 16 || bits == 32 || bits == 64;
            if (predictor == PREDICTOR_HORIZONTAL && !whole_words) continue;
            if (predictor == PREDICTOR_FLOATINGPOINT && bits != 32 && bits != 64) continue;
            if (kind.is_float && bits < 32) continue;
            kind.rows_per_strip = samples == 1 ? 300 : 170;
            SCOPED_TRACE(::testing::Message() << "compression " << compression << " predictor " << predictor << " bits " << bits
                                              << " samples " << samples << " big-endian " << is_big_endian);
            write_strips(folder / "strip.tif", kind, samples_of(kind));

            TIFF* tiff = TIFFOpen((folder / "strip.tif").c_str(), "r");
            ASSERT_NE(tiff, nullptr);
            const auto last = TIFFNumberOfStrips(tiff) - 1;
            const std::size_t rows = kind.height - last * kind.rows_per_strip;
            std::vector<std::byte> expected(rows * row_bytes(kind));
            ASSERT_EQ(TIFFReadEncodedStrip(tiff, last, expected.data(), -1), static_cast<tmsize_t>(expected.size()));
            TIFFClose(tiff);

            const auto open = open_strip(folder / "strip.tif");
            ASSERT_TRUE(open.has_value()) << open.error().message;
            ASSERT_TRUE(StripStream::can_unpack(open->layout));
            auto stream = StripStream::open(open->file, open->layout, open->strip);
            ASSERT_TRUE(stream.has_value()) << stream.error().message;
            std::vector<std::byte> got(expected.size());
            std::size_t row = 0;
            for (std::size_t step = 1; row < rows; row += step, step = 1 + step * 2 % 37) {
              step = std::min(step, rows - row);
              const auto read =
                  (*stream)->read_rows(std::span(got).subspan(row * row_bytes(kind), step * row_bytes(kind)), row_bytes(kind));
              ASSERT_TRUE(read.has_value()) << read.error().message;
            }
            EXPECT_EQ((*stream)->next_row(), kind.height);
            ASSERT_EQ(got, expected);
            std::vector<std::byte> beyond(row_bytes(kind));
            EXPECT_FALSE((*stream)->read_rows(beyond, row_bytes(kind)).has_value());
            ++count;
          }
        }
      }
    }
  }
  EXPECT_GT(count, 90);
}

TEST(StripStream, TruncatedStripsAreErrors) {
  const TempFolder folder;
  for (const std::uint16_t compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
    const StripFile kind{.compression = compression, .width = 40, .height = 60, .rows_per_strip = 60};
    const auto samples = samples_of(kind);
    write_strips(folder / "strip.tif", kind, samples);
    auto open = open_strip(folder / "strip.tif");
    ASSERT_TRUE(open.has_value()) << open.error().message;
    const std::uint64_t whole = open->strip.bytes;
    for (open->strip.bytes = 0; open->strip.bytes < whole; ++open->strip.bytes) {
      std::vector<std::byte> got(samples.size());
      const auto stream = StripStream::open(open->file, open->layout, open->strip);
      ASSERT_TRUE(stream.has_value());
      const auto read = (*stream)->read_rows(got, row_bytes(kind));
      EXPECT_TRUE(!read || got == samples) << open->strip.bytes << " of " << whole;
    }
  }
}

TEST(StripStream, FlippedBitsNeverCrash) {
  const TempFolder folder;
  std::mt19937 random(3);
  for (const std::uint16_t compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
    const StripFile kind{.compression = compression, .predictor = PREDICTOR_HORIZONTAL, .width = 90, .height = 200, .rows_per_strip = 200};
    const auto samples = samples_of(kind);
    write_strips(folder / "strip.tif", kind, samples);
    std::ifstream file(folder / "strip.tif", std::ios::binary);
    const std::string good((std::istreambuf_iterator<char>(file)), {});
    const auto open = open_strip(folder / "strip.tif");
    ASSERT_TRUE(open.has_value());
    for (int i = 0; i < 400; ++i) {
      std::string bad = good;
      for (int flips = 0; flips < 3; ++flips)
        bad[open->strip.offset + random() % open->strip.bytes] ^= static_cast<char>(1U << random() % 8);
      std::fstream(folder / "bad.tif", std::ios::binary | std::ios::in | std::ios::out | (i == 0 ? std::ios::trunc : std::ios::openmode{}))
          << bad;
      const auto damaged = FileBytes::open(folder / "bad.tif");
      ASSERT_TRUE(damaged.has_value());
      const auto stream = StripStream::open(*damaged, open->layout, open->strip);
      std::vector<std::byte> got(samples.size());
      if (stream) static_cast<void>((*stream)->read_rows(got, row_bytes(kind)));
    }
  }
}

}  // namespace
}  // namespace vt::source
