#include "tools/vtbench/inputs/tiled_tiff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "builder/source/raster_source.h"
#include "tests/support/temp_folder.h"

namespace vt::bench {
namespace {

constexpr std::int64_t kTile = 16;

// What the texel at (x, y) of stored tile `tile` is.
std::array<std::byte, 3> texel(std::uint32_t tile, std::int64_t x, std::int64_t y) {
  return {static_cast<std::byte>(tile), static_cast<std::byte>(x * 16 + y), static_cast<std::byte>(tile * 31 + 7)};
}

void write(const std::filesystem::path& path, const TiledTiffSpec& spec, std::uint32_t stored, std::span<const std::uint32_t> table) {
  auto writer = TiledTiffWriter::create(path, spec);
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  for (std::uint32_t tile = 0; tile < stored; ++tile) {
    std::vector<std::byte> rgb;
    for (std::int64_t y = 0; y < kTile; ++y)
      for (std::int64_t x = 0; x < kTile; ++x)
        for (const std::byte sample : texel(tile, x, y)) rgb.push_back(sample);
    ASSERT_TRUE(writer->add_tile(rgb).has_value());
  }
  const auto finished = writer->finish(table);
  ASSERT_TRUE(finished.has_value()) << finished.error().message;
}

// Every texel of the file, by our reader, is that of the tile which the table names.
void expect_reads_back(const std::filesystem::path& path, const TiledTiffSpec& spec, std::span<const std::uint32_t> table) {
  const auto raster = source::open_raster(path);
  ASSERT_TRUE(raster.has_value()) << raster.error().message;
  const source::RasterInfo& info = (*raster)->info();
  ASSERT_EQ(info.width, spec.width);
  ASSERT_EQ(info.height, spec.height);
  ASSERT_EQ(info.bands, 3);
  EXPECT_TRUE(info.tiled);
  EXPECT_EQ(info.compression, "none");
  std::vector<std::byte> rgb(static_cast<std::size_t>(info.width * info.height * 3));
  const auto read = (*raster)->read({0, 0, info.width, info.height}, std::array{0, 1, 2}, rgb, static_cast<std::size_t>(info.width * 3));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  for (std::int64_t y = 0; y < info.height; ++y)
    for (std::int64_t x = 0; x < info.width; ++x) {
      const auto wanted = texel(table[static_cast<std::size_t>(y / kTile * spec.columns() + x / kTile)], x % kTile, y % kTile);
      const auto* found = rgb.data() + (y * info.width + x) * 3;
      ASSERT_TRUE(std::equal(wanted.begin(), wanted.end(), found)) << x << ", " << y;
    }
}

TEST(TiledTiff, OurReaderFindsEveryTileWhereTheTableSaysHoweverOftenItIsNamed) {
  const test::TempFolder folder;
  const TiledTiffSpec spec{.width = 19 * kTile, .height = 7 * kTile, .tile = kTile};
  const auto table = scattered_tiles(spec.columns(), spec.rows(), 5);
  write(folder / "many.tif", spec, 5, table);
  expect_reads_back(folder / "many.tif", spec, table);
  // Five tiles are stored, 133 are there.
  EXPECT_LT(std::filesystem::file_size(folder / "many.tif"), 4096U + 5U * kTile * kTile * 3U + 4096U);
}

// As many tiles as 16 gigapixels have at 256 texels a tile.
TEST(TiledTiff, ATableOfAQuarterMillionTilesIsReadAtItsFarEnd) {
  const test::TempFolder folder;
  const TiledTiffSpec spec{.width = 512 * kTile, .height = 512 * kTile, .tile = kTile};
  const auto table = scattered_tiles(spec.columns(), spec.rows(), 4);
  write(folder / "wide.tif", spec, 4, table);
  const auto raster = source::open_raster(folder / "wide.tif");
  ASSERT_TRUE(raster.has_value()) << raster.error().message;
  for (const std::size_t tile : {std::size_t{0}, std::size_t{511}, table.size() - 1}) {
    std::vector<std::byte> rgb(static_cast<std::size_t>(kTile * kTile * 3));
    const auto column = static_cast<std::int64_t>(tile % 512);
    const auto row = static_cast<std::int64_t>(tile / 512);
    ASSERT_TRUE((*raster)->read({column * kTile, row * kTile, kTile, kTile}, std::array{0, 1, 2}, rgb, kTile * 3).has_value());
    const auto wanted = texel(table[tile], 0, 0);
    EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), rgb.begin())) << tile;
  }
}

// Values of at most eight bytes lie in the directory itself.
TEST(TiledTiff, OneTileAndTwoTilesReadBack) {
  const test::TempFolder folder;
  for (const std::int64_t columns : {1, 2}) {
    const TiledTiffSpec spec{.width = columns * kTile, .height = 1 * kTile, .tile = kTile};
    const std::vector<std::uint32_t> table(static_cast<std::size_t>(columns), 0U);
    const auto path = folder / std::to_string(columns);
    write(path, spec, 1, table);
    expect_reads_back(path, spec, table);
  }
}

TEST(TiledTiff, TilesThatStickOutAreCutOff) {
  const test::TempFolder folder;
  const TiledTiffSpec spec{.width = 2 * kTile + 5, .height = kTile + 1, .tile = kTile};
  EXPECT_EQ(spec.columns(), 3);
  EXPECT_EQ(spec.rows(), 2);
  const auto table = scattered_tiles(spec.columns(), spec.rows(), 3);
  write(folder / "odd.tif", spec, 3, table);
  expect_reads_back(folder / "odd.tif", spec, table);
}

TEST(TiledTiff, SaysWhereItLies) {
  const test::TempFolder folder;
  TiledTiffSpec spec{.width = 2 * kTile, .height = 1 * kTile, .tile = kTile};
  spec.transform = geo::GeoTransform{400000.0, 0.5, 0.0, 5600000.0, 0.0, -2.0};
  spec.crs = geo::Crs::from_epsg(32633).value();
  const std::array<std::uint32_t, 2> table = {1, 0};
  write(folder / "placed.tif", spec, 2, table);
  expect_reads_back(folder / "placed.tif", spec, table);
  const auto raster = source::open_raster(folder / "placed.tif");
  ASSERT_TRUE(raster.has_value());
  const source::RasterInfo& info = (*raster)->info();
  ASSERT_TRUE(info.crs.has_value()) << info.crs_problem;
  EXPECT_TRUE(info.crs->same_coordinates(*spec.crs));
  ASSERT_TRUE(info.has_transform);
  EXPECT_EQ(info.transform.x0, 400000.0);
  EXPECT_EQ(info.transform.x_column, 0.5);
  EXPECT_EQ(info.transform.y0, 5600000.0);
  EXPECT_EQ(info.transform.y_row, -2.0);
}

TEST(ScatteredTiles, NeighboursDifferEveryTileOccursAndTheTableIsAlwaysTheSame) {
  for (const std::uint32_t stored : {3U, 4U, 50U}) {
    const auto table = scattered_tiles(40, 30, stored);
    ASSERT_EQ(table.size(), 1200U);
    EXPECT_EQ(table, scattered_tiles(40, 30, stored));
    EXPECT_EQ(std::set(table.begin(), table.end()).size(), stored);
    EXPECT_LT(*std::max_element(table.begin(), table.end()), stored);
    for (std::size_t i = 0; i < table.size(); ++i) {
      EXPECT_FALSE(i % 40 > 0 && table[i] == table[i - 1]) << i;
      EXPECT_FALSE(i >= 40 && table[i] == table[i - 40]) << i;
    }
  }
}

}  // namespace
}  // namespace vt::bench
