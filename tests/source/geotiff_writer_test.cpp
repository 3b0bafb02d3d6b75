// What the writer writes, the reader reads: pixels, place, CRS, nodata, alpha; and what goes wrong leaves no
// file.
#include "builder/source/tiff/geotiff_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "builder/source/raster_source.h"
#include "tests/source/raster_files.h"
#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;
using Compression = GeoTiffSpec::Compression;

TEST(GeoTiffWriter, EveryTypeLayoutAndLosslessCompressionReadsBackIdentically) {
  const TempFolder folder;
  std::uint32_t seed = 0;
  for (const SampleType type : {SampleType::kUint8, SampleType::kInt8, SampleType::kUint16, SampleType::kInt16, SampleType::kUint32,
                                SampleType::kInt32, SampleType::kFloat32, SampleType::kFloat64}) {
    for (const Compression compression : {Compression::kNone, Compression::kDeflate, Compression::kLzw, Compression::kZstd}) {
      for (const int tile : {0, 16, 64}) {
        for (const int bands : {1, 3, 5}) {
          GeoTiffSpec spec;
          spec.width = 83;  // prime: tiles and strips stick out
          spec.height = 71;
          spec.bands = bands;
          spec.sample_type = type;
          spec.compression = compression;
          spec.tile = tile;
          spec.last_band_is_alpha = bands == 5;
          SCOPED_TRACE(std::string(sample_name(type)) + " compression " + std::to_string(static_cast<int>(compression)) + " tile " +
                       std::to_string(tile) + " bands " + std::to_string(bands));
          const auto path = folder / "round.tif";
          const auto samples = noise(static_cast<std::size_t>(83 * 71 * bands) * sample_bytes(type), ++seed);
          write(path, spec, samples, 1 + seed % 40);
          const auto source = open_raster(path);
          ASSERT_TRUE(source.has_value()) << source.error().message;
          EXPECT_EQ((*source)->info().sample_type, type);
          EXPECT_EQ((*source)->info().bands, bands);
          EXPECT_EQ((*source)->info().alpha_band, bands == 5 ? 4 : -1);
          EXPECT_EQ((*source)->info().tiled, tile > 0);
          EXPECT_EQ(read_all(**source), samples);
        }
      }
    }
  }
}

TEST(GeoTiffWriter, PlaceCrsAndNodataReadBackExactly) {
  const TempFolder folder;
  const geo::GeoTransform grids[] = {
      {.x0 = 440720.1, .x_column = 60.3, .x_row = 0.0, .y0 = 3751320.7, .y_column = 0.0, .y_row = -60.7},
      {.x0 = 440720.1, .x_column = 60.3, .x_row = 0.0, .y0 = 3751320.7, .y_column = 0.0, .y_row = 60.7},
      {.x0 = 1.0 / 3.0, .x_column = 0.8, .x_row = 0.6, .y0 = 2.0 / 3.0, .y_column = 0.6, .y_row = -0.8},
  };
  const std::optional<double> nodata_values[] = {std::nullopt,         -9999.0, 0.1F, std::numeric_limits<double>::quiet_NaN(), -INFINITY,
                                                 3.4028234663852886e38};
  for (const geo::GeoTransform& grid : grids) {
    for (const auto& nodata : nodata_values) {
      GeoTiffSpec spec;
      spec.width = spec.height = 5;
      spec.sample_type = SampleType::kFloat32;
      spec.transform = grid;
      spec.crs = geo::Crs::from_epsg(31985).value();
      spec.nodata = nodata;
      const auto path = folder / "place.tif";
      write(path, spec, noise(100, 1), 5);
      const auto source = open_raster(path);
      ASSERT_TRUE(source.has_value()) << source.error().message;
      const RasterInfo& info = (*source)->info();
      ASSERT_TRUE(info.has_transform);
      EXPECT_EQ(info.transform.x0, grid.x0);
      EXPECT_EQ(info.transform.x_column, grid.x_column);
      EXPECT_EQ(info.transform.x_row, grid.x_row);
      EXPECT_EQ(info.transform.y0, grid.y0);
      EXPECT_EQ(info.transform.y_column, grid.y_column);
      EXPECT_EQ(info.transform.y_row, grid.y_row);
      ASSERT_TRUE(info.crs.has_value()) << info.crs_problem;
      EXPECT_EQ(info.crs->definition().epsg, 31985);
      const std::optional<double>& read = info.meaning.at(0).nodata;
      ASSERT_EQ(read.has_value(), nodata.has_value());
      EXPECT_TRUE(!nodata || *read == *nodata || (std::isnan(*read) && std::isnan(*nodata))) << *read;
    }
  }
}

TEST(GeoTiffWriter, JpegKeepsSmoothColourWithinAFewCodes) {
  const TempFolder folder;
  for (const int tile : {0, 64}) {
    GeoTiffSpec spec;
    spec.width = 100;
    spec.height = 90;
    spec.bands = 3;
    spec.compression = Compression::kJpeg;
    spec.tile = tile;
    std::vector<std::byte> ramp;
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 100; ++x) {
        for (const int code : {x * 2, y * 2, 128}) ramp.push_back(static_cast<std::byte>(code));
      }
    }
    write(folder / "jpeg.tif", spec, ramp, 7);
    const auto source = open_raster(folder / "jpeg.tif");
    ASSERT_TRUE(source.has_value()) << source.error().message;
    const auto back = read_all(**source);
    for (std::size_t i = 0; i < ramp.size(); ++i) {
      ASSERT_NEAR(std::to_integer<int>(back[i]), std::to_integer<int>(ramp[i]), 12) << i;  // quality 75 with subsampled chroma
    }
  }
}

TEST(GeoTiffWriter, UnfinishedFilesVanish) {
  const TempFolder folder;
  GeoTiffSpec spec;
  spec.width = spec.height = 64;
  {
    auto writer = GeoTiffWriter::create(folder / "never.tif", spec);
    ASSERT_TRUE(writer.has_value());
    ASSERT_TRUE(writer->write_rows(noise(64 * 10, 1), 10).has_value());
    const auto early = writer->finish();
    ASSERT_FALSE(early.has_value());
    EXPECT_EQ(early.error().code, ErrorCode::kUsage);
    EXPECT_FALSE(writer->write_rows(noise(64 * 55, 1), 55).has_value());  // one row too many
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "never.tif"));
  EXPECT_FALSE(std::filesystem::exists(folder / "never.tif.partial"));
  const auto nowhere = GeoTiffWriter::create(folder / "no/such/folder.tif", spec);
  ASSERT_FALSE(nowhere.has_value());
  EXPECT_EQ(nowhere.error().code, ErrorCode::kIo);
}

TEST(GeoTiffReader, WindowsFromManyThreadsAgreeWithTheWhole) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kNone, Compression::kDeflate}) {
    for (const int tile : {0, 32}) {
      GeoTiffSpec spec;
      spec.width = 211;
      spec.height = 307;
      spec.bands = 3;
      spec.sample_type = SampleType::kUint16;
      spec.compression = compression;
      spec.tile = tile;
      spec.rows_per_strip = 9;
      const auto samples = noise(211 * 307 * 3 * 2, 3);
      write(folder / "threads.tif", spec, samples, 50);
      OpenOptions options;
      options.cache_bytes = 20000;  // a few blocks: eviction all the time
      const auto source = open_raster(folder / "threads.tif", options);
      ASSERT_TRUE(source.has_value()) << source.error().message;
      std::vector<std::jthread> threads;
      for (std::uint32_t i = 0; i < 4; ++i) threads.emplace_back([&, i] { expect_windows_match(**source, samples, i, 25); });
    }
  }
}

TEST(GeoTiffReader, OneStripForTheWholeImageIsReadInParts) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kNone, Compression::kDeflate, Compression::kZstd, Compression::kLzw}) {
    GeoTiffSpec spec;
    spec.width = 3000;
    spec.height = 2500;
    spec.bands = 3;
    spec.compression = compression;
    spec.tile = 0;
    spec.rows_per_strip = 2500;  // 22.5 MB, more than a cell may have
    const auto samples = noise(3000 * 2500 * 3, 4);
    write(folder / "strip.tif", spec, samples, 2500);
    const auto source = open_raster(folder / "strip.tif");
    ASSERT_TRUE(source.has_value()) << source.error().message;
    EXPECT_EQ((*source)->info().block_height, 2500);
    expect_windows_match(**source, samples, 5, 6);
  }
}

TEST(GeoTiffReader, BadRequestsAreUsageErrors) {
  const TempFolder folder;
  GeoTiffSpec spec;
  spec.width = spec.height = 20;
  write(folder / "small.tif", spec, noise(400, 1), 20);
  const auto source = open_raster(folder / "small.tif");
  ASSERT_TRUE(source.has_value());
  std::vector<std::byte> out(400);
  const std::vector<int> first = {0};
  const std::vector<int> second = {1};
  for (const Window& w : {Window{-1, 0, 5, 5}, Window{0, 0, 21, 1}, Window{0, 19, 1, 2}, Window{0, 0, 0, 5}, Window{INT64_MAX, 0, 1, 1}}) {
    const auto read = (*source)->read(w, first, out, 20);
    ASSERT_FALSE(read.has_value());
    EXPECT_EQ(read.error().code, ErrorCode::kUsage);
  }
  EXPECT_FALSE((*source)->read({0, 0, 5, 5}, second, out, 20).has_value());
  EXPECT_FALSE((*source)->read({0, 0, 20, 20}, first, std::span(out).first(399), 20).has_value());
  EXPECT_FALSE((*source)->read({0, 0, 20, 20}, first, out, 19).has_value());
}

TEST(GeoTiffReader, EveryTruncationIsAnErrorOrTheFullPicture) {
  const TempFolder folder;
  for (const Compression compression : {Compression::kNone, Compression::kDeflate}) {
    GeoTiffSpec spec;
    spec.width = 40;
    spec.height = 33;
    spec.bands = 3;
    spec.compression = compression;
    spec.tile = 16;
    spec.crs = geo::Crs::from_epsg(32633).value();
    spec.transform = geo::GeoTransform{.x0 = 5e5, .x_column = 2, .x_row = 0, .y0 = 5e6, .y_column = 0, .y_row = -2};
    const auto samples = noise(40 * 33 * 3, 8);
    write(folder / "whole.tif", spec, samples, 33);
    std::ifstream file(folder / "whole.tif", std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    for (std::size_t length = bytes.size(); length-- > 0;) {
      std::filesystem::resize_file(folder / "whole.tif", length);
      const auto source = open_raster(folder / "whole.tif");
      if (!source) continue;
      const RasterInfo& info = (*source)->info();
      ASSERT_EQ(info.width, 40);
      const std::size_t pitch = 40 * static_cast<std::size_t>(info.bands);
      std::vector<std::byte> out(pitch * static_cast<std::size_t>(info.height));
      const auto read = (*source)->read({0, 0, info.width, info.height}, all_bands(info.bands), out, pitch);
      EXPECT_TRUE(!read || out == samples) << length << " of " << bytes.size() << " bytes";
    }
  }
}

TEST(GeoTiffReader, FlippedBitsNeverCrash) {
  const TempFolder folder;
  std::mt19937 random(11);
  for (const Compression compression : {Compression::kNone, Compression::kLzw, Compression::kZstd}) {
    GeoTiffSpec spec;
    spec.width = 40;
    spec.height = 33;
    spec.compression = compression;
    spec.tile = 16;
    spec.crs = geo::Crs::from_epsg(32633).value();
    spec.nodata = 7.0;
    write(folder / "good.tif", spec, noise(40 * 33, 8), 33);
    std::ifstream file(folder / "good.tif", std::ios::binary);
    const std::string good((std::istreambuf_iterator<char>(file)), {});
    for (int i = 0; i < 1500; ++i) {
      std::string bad = good;
      for (int flips = 0; flips < 4; ++flips) bad[random() % bad.size()] ^= static_cast<char>(1U << random() % 8);
      std::fstream(folder / "good.tif", std::ios::binary | std::ios::in | std::ios::out)
          << bad;  // in place: truncating first costs a disk write
      const auto source = open_raster(folder / "good.tif");
      if (!source) continue;
      const RasterInfo& info = (*source)->info();
      const std::int64_t width = std::min<std::int64_t>(info.width, 256);
      const std::int64_t height = std::min<std::int64_t>(info.height, 256);
      const std::size_t pitch = static_cast<std::size_t>(width) * static_cast<std::size_t>(info.bands) * sample_bytes(info.sample_type);
      if (pitch > 1 << 20) continue;
      std::vector<std::byte> out(pitch * static_cast<std::size_t>(height));
      static_cast<void>((*source)->read({0, 0, width, height}, all_bands(info.bands), out, pitch));
    }
  }
}

TEST(RasterSource, MissingAndForeignFilesAreErrors) {
  const TempFolder folder;
  EXPECT_EQ(open_raster(folder / "none.tif").error().code, ErrorCode::kIo);
  EXPECT_EQ(open_raster(folder / "").error().code, ErrorCode::kIo);
  std::ofstream(folder / "text.tif") << "not a picture";
  const auto foreign = open_raster(folder / "text.tif");
  ASSERT_FALSE(foreign.has_value());
  std::ofstream(folder / "empty.tif");
  EXPECT_FALSE(open_raster(folder / "empty.tif").has_value());
}

TEST(RasterSource, ExtentAndCrsFromTheCallerWin) {
  const TempFolder folder;
  GeoTiffSpec spec;
  spec.width = 20;
  spec.height = 10;
  write(folder / "plain.tif", spec, noise(200, 1), 10);
  EXPECT_FALSE((*open_raster(folder / "plain.tif"))->info().has_transform);
  OpenOptions options;
  options.crs = geo::Crs::from_epsg(4326).value();
  options.extent = Area{.west = -180.0, .south = -90.0, .east = 180.0, .north = 90.0};
  options.nodata = 3.0;
  const auto source = open_raster(folder / "plain.tif", options);
  ASSERT_TRUE(source.has_value());
  const RasterInfo& info = (*source)->info();
  EXPECT_EQ(info.transform.apply({0, 0}).x, -180.0);
  EXPECT_EQ(info.transform.apply({20, 10}).x, 180.0);
  EXPECT_EQ(info.transform.apply({20, 10}).y, -90.0);
  EXPECT_EQ(info.crs->definition().epsg, 4326);
  EXPECT_EQ(info.meaning.at(0).nodata, 3.0);
  std::swap(options.extent->west, options.extent->east);
  EXPECT_EQ(open_raster(folder / "plain.tif", options).error().code, ErrorCode::kUsage);

  // A world file counts from the centre of the first sample.
  std::ofstream(folder / "plain.tfw") << "2.0\n0.0\n0.0\n-2.0\n101.0\n199.0\n";
  const auto placed = open_raster(folder / "plain.tif");
  ASSERT_TRUE(placed.has_value());
  EXPECT_EQ((*placed)->info().transform.x0, 100.0);
  EXPECT_EQ((*placed)->info().transform.y0, 200.0);
  std::ofstream(folder / "plain.tfw") << "2.0\n0.0\nnonsense";
  EXPECT_EQ(open_raster(folder / "plain.tif").error().code, ErrorCode::kInvalidData);
}

}  // namespace
}  // namespace vt::source
