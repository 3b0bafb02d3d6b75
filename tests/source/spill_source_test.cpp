// Files that can only be decoded from the top, and strips wider than a block: read in blocks by several
// threads they give what the whole image has, and are decoded once.
#include <gtest/gtest.h>

#include <filesystem>

#include "builder/source/cells/block_cache.h"
#include "builder/source/cells/scratch_file.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "tests/source/block_walk.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;
using Compression = GeoTiffSpec::Compression;

GeoTiffSpec strips(Compression compression, std::int64_t width, std::int64_t height, std::int64_t rows_per_strip) {
  GeoTiffSpec spec;
  spec.width = width;
  spec.height = height;
  spec.bands = 3;
  spec.compression = compression;
  spec.tile = 0;
  spec.rows_per_strip = rows_per_strip;
  return spec;
}

OpenOptions with_scratch(const TempFolder& folder, std::size_t cache_bytes) {
  OpenOptions options;
  options.cache = std::make_shared<BlockCache>(cache_bytes);
  options.scratch = std::make_shared<ScratchFile>(folder.path());
  return options;
}

// The samples of a file as one read of a source with nothing shared gives them.
std::vector<std::byte> plain_samples(const std::filesystem::path& path) {
  const auto source = open_raster(path);
  EXPECT_TRUE(source.has_value());
  return read_all(**source);
}

TEST(SpilledSource, OneStripIsDecodedOnceInAWalkOverBlocks) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kDeflate, Compression::kLzw, Compression::kZstd, Compression::kJpeg}) {
    SCOPED_TRACE(static_cast<int>(compression));
    const auto samples = noise(1500 * 1900 * 3, 4);
    write(folder / "strip.tif", strips(compression, 1500, 1900, 1900), samples, 100);
    const auto whole = plain_samples(folder / "strip.tif");
    ASSERT_TRUE(compression == Compression::kJpeg || whole == samples);
    for (const bool releases : {false, true}) {
      const OpenOptions options = with_scratch(folder, std::size_t{8} << 20);  // of 8.6 MB
      const auto source = open_raster(folder / "strip.tif", options);
      ASSERT_TRUE(source.has_value()) << source.error().message;
      expect_walk_matches(**source, whole, {.block = 400, .releases = releases});
      EXPECT_EQ((*source)->decoded_bytes(), 1500U * 1900 * 3);
      EXPECT_TRUE(!releases || options.scratch->bytes_on_disk() < 1500U * 1900 * 3 * 3 / 4);
      expect_windows_match(**source, whole, 5, 10);  // released or not
    }
  }
}

TEST(SpilledSource, SeveralLargeStripsAreDecodedOnceEach) {
  const TempFolder folder;
  const auto samples = noise(1500 * 1900 * 3, 4);
  write(folder / "strips.tif", strips(Compression::kZstd, 1500, 1900, 700), samples, 100);
  const auto source = open_raster(folder / "strips.tif", with_scratch(folder, std::size_t{8} << 20));
  ASSERT_TRUE(source.has_value());
  expect_walk_matches(**source, samples, {.block = 400, .threads = 4, .releases = true});
  EXPECT_EQ((*source)->decoded_bytes(), 1500U * 1900 * 3);
}

TEST(SpilledSource, StripsWiderThanABlockAreDecodedOnce) {
  const TempFolder folder;
  const auto samples = noise(6000 * 300 * 3, 9);
  write(folder / "wide.tif", strips(Compression::kDeflate, 6000, 300, 8), samples, 100);
  {
    const auto source = open_raster(folder / "wide.tif", with_scratch(folder, std::size_t{2} << 20));
    ASSERT_TRUE(source.has_value());
    expect_walk_matches(**source, samples, {.block = 100, .threads = 3, .releases = true});
    EXPECT_EQ((*source)->decoded_bytes(), 6000U * 300 * 3);
  }
  // An image that fits into the cache needs no disk.
  const OpenOptions options = with_scratch(folder, std::size_t{64} << 20);
  const auto source = open_raster(folder / "wide.tif", options);
  ASSERT_TRUE(source.has_value());
  expect_walk_matches(**source, samples, {.block = 100, .threads = 3});
  EXPECT_EQ((*source)->decoded_bytes(), 6000U * 300 * 3);
  EXPECT_EQ(options.scratch->bytes_on_disk(), 0U);
}

TEST(SpilledSource, TilesNeedNoDisk) {
  const TempFolder folder;
  GeoTiffSpec spec = strips(Compression::kDeflate, 6000, 300, 8);
  spec.tile = 64;
  const auto samples = noise(6000 * 300 * 3, 9);
  write(folder / "tiles.tif", spec, samples, 64);
  const OpenOptions options = with_scratch(folder, std::size_t{2} << 20);
  const auto source = open_raster(folder / "tiles.tif", options);
  ASSERT_TRUE(source.has_value());
  expect_walk_matches(**source, samples, {.block = 128, .threads = 3});
  EXPECT_EQ(options.scratch->bytes_on_disk(), 0U);
}

TEST(SpilledSource, AFullDiskStopsTheReader) {
  const TempFolder folder;
  write(folder / "strip.tif", strips(Compression::kDeflate, 1500, 1900, 1900), noise(1500 * 1900 * 3, 4), 100);
  OpenOptions options = with_scratch(folder, std::size_t{8} << 20);
  options.scratch = std::make_shared<ScratchFile>(folder.path(), 3000000);
  const auto source = open_raster(folder / "strip.tif", options);
  ASSERT_TRUE(source.has_value());
  std::vector<std::byte> out(1500 * 3);
  EXPECT_TRUE((*source)->read({0, 0, 1500, 1}, all_bands(3), out, 1500 * 3).has_value());
  const auto read = (*source)->read({0, 1800, 1500, 1}, all_bands(3), out, 1500 * 3);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kIo);
  EXPECT_NE(read.error().message.find("scratch"), std::string::npos) << read.error().message;
}

}  // namespace
}  // namespace vt::source
