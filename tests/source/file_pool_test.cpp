// Many sources, few descriptors: files are closed behind the reader's back and opened again, and one that
// changed meanwhile is noticed.
#include "builder/source/files/file_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "builder/source/cells/block_cache.h"
#include "builder/source/files/file_bytes.h"
#include "builder/source/raster_source.h"
#include "builder/source/tiff/geotiff_writer.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;

constexpr int kFiles = 120;

std::size_t descriptors_of_this_process() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

GeoTiffSpec small_spec(int i) {
  GeoTiffSpec spec;
  spec.width = 40;
  spec.height = 30;
  spec.tile = 16;
  spec.compression = i % 2 == 0 ? GeoTiffSpec::Compression::kDeflate : GeoTiffSpec::Compression::kNone;
  return spec;
}

std::vector<std::filesystem::path> write_many(const TempFolder& folder) {
  std::vector<std::filesystem::path> paths;
  for (int i = 0; i < kFiles; ++i) {
    paths.push_back(folder / (std::to_string(i) + ".tif"));
    write(paths.back(), small_spec(i), noise(40 * 30, static_cast<std::uint32_t>(i)), 30);
  }
  return paths;
}

// Opens all files and reads each several times, from four threads, in another order each.
void open_and_read_all(const std::vector<std::filesystem::path>& paths, const OpenOptions& options, std::size_t most_descriptors) {
  std::vector<std::unique_ptr<RasterSource>> sources(paths.size());
  std::atomic<std::size_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (std::size_t at = next++; at < paths.size(); at = next++) {
          auto source = open_raster(paths[at], options);
          ASSERT_TRUE(source.has_value()) << source.error().message;
          sources[at] = std::move(*source);
        }
      });
    }
  }
  EXPECT_LE(options.files->open_descriptors(), most_descriptors);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < 4; ++i) {
      threads.emplace_back([&, i] {
        for (std::size_t at = i; at < 3 * sources.size(); at += 7) {
          const std::size_t which = at % sources.size();
          EXPECT_EQ(read_all(*sources[which]), noise(40 * 30, static_cast<std::uint32_t>(which))) << which;
        }
      });
    }
  }
  EXPECT_LE(options.files->open_descriptors(), most_descriptors + 4);  // threads in the middle of a read may push it up
}

TEST(FilePool, HundredsOfSourcesShareAFewDescriptors) {
  const TempFolder folder;
  const auto paths = write_many(folder);
  OpenOptions options;
  options.files = std::make_shared<FilePool>(5);
  options.cache = std::make_shared<BlockCache>(10000);
  const std::size_t before = descriptors_of_this_process();
  open_and_read_all(paths, options, 5);
  EXPECT_LE(descriptors_of_this_process(), before) << "sources that are gone leave nothing open";
}

TEST(FilePool, StaysBelowTheProcessLimit) {
  const TempFolder folder;
  const auto paths = write_many(folder);
  struct rlimit limit {};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  struct rlimit small = limit;
  small.rlim_cur = 64;
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &small), 0);
  EXPECT_EQ(FilePool::default_limit(), 16U);
  OpenOptions options;
  options.files = std::make_shared<FilePool>();
  options.cache = std::make_shared<BlockCache>(10000);
  open_and_read_all(paths, options, 16);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
}

TEST(FilePool, AFileThatChangedBetweenTwoReadsIsNamed) {
  const TempFolder folder;
  for (const int kind : {0, 1}) {  // compressed, not compressed
    const auto path = folder / "changes.tif";
    write(path, small_spec(kind), noise(40 * 30, 1), 30);
    OpenOptions options;
    options.files = std::make_shared<FilePool>(1);
    options.cache = std::make_shared<BlockCache>(1);
    const auto source = open_raster(path, options);
    ASSERT_TRUE(source.has_value());
    EXPECT_EQ(read_all(**source), noise(40 * 30, 1));
    write(folder / "other.tif", small_spec(kind), noise(40 * 30, 2), 30);
    const auto other = open_raster(folder / "other.tif", options);  // takes the only descriptor
    ASSERT_TRUE(other.has_value());
    EXPECT_EQ(read_all(**source), noise(40 * 30, 1)) << "the same file, opened again";

    EXPECT_EQ(read_all(**other), noise(40 * 30, 2));
    write(path, small_spec(kind), noise(40 * 30, 3), 30);  // replaced by a file of the same size
    std::vector<std::byte> out(40 * 30);
    const auto read = (*source)->read({0, 0, 40, 30}, all_bands(1), out, 40);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().code, ErrorCode::kIo);
    EXPECT_NE(read.error().message.find("changes.tif"), std::string::npos);
    EXPECT_NE(read.error().message.find("changed"), std::string::npos) << read.error().message;

    std::filesystem::remove(path);
    EXPECT_FALSE((*source)->read({0, 0, 40, 30}, all_bands(1), out, 40).has_value());
  }
}

}  // namespace
}  // namespace vt::source
