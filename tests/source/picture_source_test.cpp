// Pictures that are not TIFF, read in blocks by several threads: decoded once where they must be decoded from
// the top, tile by tile where they have tiles. Written with stb and OpenEXR, not with what reads them.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "builder/source/cells/block_cache.h"
#include "builder/source/cells/scratch_file.h"
#include "builder/source/files/file_pool.h"
#include "builder/source/raster_source.h"
#include "tests/source/block_walk.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace vt::source {
namespace {

using test::TempFolder;

constexpr int kWidth = 1300;
constexpr int kHeight = 1100;
constexpr std::uint64_t kImageBytes = std::uint64_t{kWidth} * kHeight * 3;  // 4.3 MB

OpenOptions with_scratch(const TempFolder& folder, std::size_t cache_bytes) {
  OpenOptions options;
  options.cache = std::make_shared<BlockCache>(cache_bytes);
  options.files = std::make_shared<FilePool>();
  options.scratch = std::make_shared<ScratchFile>(folder.path());
  return options;
}

void write_png(const std::filesystem::path& path, const std::vector<std::byte>& samples) {
  ASSERT_NE(stbi_write_png(path.c_str(), kWidth, kHeight, 3, samples.data(), kWidth * 3), 0);
}

void write_jpeg(const std::filesystem::path& path, const std::vector<std::byte>& samples) {
  ASSERT_NE(stbi_write_jpg(path.c_str(), kWidth, kHeight, 3, samples.data(), 90), 0);
}

// Channels in alphabetical order, as the file has them; OpenImageIO turns them into R, G, B.
void write_exr(const std::filesystem::path& path, const std::vector<float>& rgb, int tile) {
  Imf::Header header(kWidth, kHeight);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  for (int band = 0; band < 3; ++band) {
    const char* const name = band == 0 ? "R" : band == 1 ? "G" : "B";
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, Imf::Slice(Imf::FLOAT, const_cast<char*>(reinterpret_cast<const char*>(rgb.data() + band)), 12, 12 * kWidth));
  }
  if (tile > 0) {
    header.setTileDescription(Imf::TileDescription(static_cast<unsigned>(tile), static_cast<unsigned>(tile)));
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(frame);
    file.writePixels(kHeight);
  }
}

std::vector<float> float_noise() {
  std::vector<float> values(kImageBytes);
  std::mt19937 random(6);
  for (float& value : values) value = static_cast<float>(random() % 1000);
  return values;
}

std::vector<std::byte> bytes_of(const std::vector<float>& values) {
  std::vector<std::byte> bytes(values.size() * sizeof(float));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

TEST(PictureSource, LargePngAndJpegAreDecodedOnceInAWalkOverBlocks) {
  const TempFolder folder;
  const auto samples = noise(kImageBytes, 4);
  write_png(folder / "a.png", samples);
  write_jpeg(folder / "a.jpg", samples);
  for (const char* name : {"a.png", "a.jpg"}) {
    SCOPED_TRACE(name);
    const auto plain = open_raster(folder / name);
    ASSERT_TRUE(plain.has_value()) << plain.error().message;
    const auto whole = read_all(**plain);
    EXPECT_TRUE(std::string_view(name) == "a.jpg" || whole == samples);
    for (const bool releases : {false, true}) {
      const auto source = open_raster(folder / name, with_scratch(folder, std::size_t{1} << 20));
      ASSERT_TRUE(source.has_value()) << source.error().message;
      expect_walk_matches(**source, whole, {.block = 300, .threads = 3, .releases = releases});
      EXPECT_EQ((*source)->decoded_bytes(), kImageBytes);
      expect_windows_match(**source, whole, 5, 10);
    }
  }
}

TEST(PictureSource, SmallPicturesAreDecodedWholeIntoTheCache) {
  const TempFolder folder;
  const auto samples = noise(kImageBytes, 4);
  write_png(folder / "a.png", samples);
  const OpenOptions options = with_scratch(folder, std::size_t{64} << 20);
  const auto source = open_raster(folder / "a.png", options);
  ASSERT_TRUE(source.has_value());
  expect_walk_matches(**source, samples, {.block = 300, .threads = 3});
  EXPECT_EQ((*source)->decoded_bytes(), kImageBytes);
  EXPECT_EQ(options.scratch->bytes_on_disk(), 0U);
}

TEST(PictureSource, OnlyTheTilesThatAreWantedAreDecoded) {
  const TempFolder folder;
  const auto values = float_noise();
  write_exr(folder / "tiles.exr", values, 64);
  const OpenOptions options = with_scratch(folder, std::size_t{1} << 20);
  const auto source = open_raster(folder / "tiles.exr", options);
  ASSERT_TRUE(source.has_value()) << source.error().message;
  ASSERT_EQ((*source)->info().block_width, 64);
  std::vector<std::byte> out(10 * 10 * 12);
  ASSERT_TRUE((*source)->read({100, 100, 10, 10}, all_bands(3), out, 120).has_value());
  EXPECT_EQ((*source)->decoded_bytes(), 64U * 64 * 12);
  expect_windows_match(**source, bytes_of(values), 3, 10);  // tiles stick out on both sides
  expect_walk_matches(**source, bytes_of(values), {.block = 256, .threads = 3});
  EXPECT_EQ(options.scratch->bytes_on_disk(), 0U);
}

TEST(PictureSource, ScanlinesOfOpenExrAreReadFromTheMiddle) {
  const TempFolder folder;
  const auto values = float_noise();
  write_exr(folder / "lines.exr", values, 0);
  const auto source = open_raster(folder / "lines.exr", with_scratch(folder, std::size_t{8} << 20));
  ASSERT_TRUE(source.has_value()) << source.error().message;
  std::vector<std::byte> out(1200);
  ASSERT_TRUE((*source)->read({0, 1000, 100, 1}, all_bands(3), out, 1200).has_value());
  EXPECT_LT((*source)->decoded_bytes(), kImageBytes * 4 / 10);
  expect_walk_matches(**source, bytes_of(values), {.block = 256, .threads = 3});
}

TEST(PictureSource, ContentIsTheWholeFile) {
  const TempFolder folder;
  const auto samples = noise(kImageBytes, 4);
  write_png(folder / "a.png", samples);
  const auto hash_of = [](const RasterSource& source, const Window& window) {
    store::ContentHasher content;
    EXPECT_TRUE(source.hash(window, std::vector<int>{0}, content).has_value());
    return content.digest();
  };
  const auto before = open_raster(folder / "a.png");
  ASSERT_TRUE(before.has_value());
  const store::ContentHash first = hash_of(**before, {0, 0, 5, 5});
  EXPECT_EQ((*before)->decoded_bytes(), 0U) << "nothing is decoded for it";
  store::ContentHasher while_reading;
  std::vector<std::byte> out(25);
  ASSERT_TRUE((*before)->read({0, 0, 5, 5}, std::vector<int>{0}, out, 5, &while_reading).has_value());
  EXPECT_EQ(while_reading.digest(), first);
  auto changed = samples;
  changed.back() ^= std::byte{1};
  write_png(folder / "b.png", changed);
  const auto after = open_raster(folder / "b.png");
  ASSERT_TRUE(after.has_value());
  EXPECT_NE(hash_of(**after, {0, 0, 5, 5}), first);
}

// Decoders that OpenImageIO holds open count, too.
TEST(PictureSource, ManyPicturesShareAFewDecoders) {
  const TempFolder folder;
  const auto samples = noise(kImageBytes, 4);
  write_jpeg(folder / "0.jpg", samples);
  OpenOptions options = with_scratch(folder, std::size_t{8} << 20);
  options.files = std::make_shared<FilePool>(6);
  std::vector<std::unique_ptr<RasterSource>> sources;
  for (int i = 0; i < 60; ++i) {
    const auto path = folder / (std::to_string(i) + ".jpg");
    if (i > 0) std::filesystem::create_hard_link(folder / "0.jpg", path);
    auto source = open_raster(path, options);
    ASSERT_TRUE(source.has_value()) << source.error().message;
    sources.push_back(std::move(*source));
  }
  const auto count = std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  EXPECT_LT(count, 60) << "of 60 pictures";
  std::vector<std::byte> first(300);
  ASSERT_TRUE(sources.front()->read({0, 500, 100, 1}, all_bands(3), first, 300).has_value());
  for (const auto& source : sources) {
    std::vector<std::byte> out(300);
    ASSERT_TRUE(source->read({0, 500, 100, 1}, all_bands(3), out, 300).has_value());
    EXPECT_EQ(out, first);
  }
}

}  // namespace
}  // namespace vt::source
