#include "store/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "store/format/layout.h"
#include "store/store_writer.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<Finding> findings_in(const std::filesystem::path& path, const ValidateOptions& options = {}) {
  return value_of(validate(path, options)).findings;
}
std::vector<int> numbers_in(const std::filesystem::path& path, const ValidateOptions& options = {}) {
  std::vector<int> numbers;
  for (const Finding& finding : findings_in(path, options)) numbers.push_back(finding.number);
  return numbers;
}

struct ValidateTest : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";
  LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 3, 3);

  // A complete layer with the tiles named.
  void build(const std::vector<TileId>& tiles, Compression compression = {}) {
    StoreWriter writer = value_of(StoreWriter::create(path, {}));
    const LayerId id = value_of(writer.add_layer(layer));
    for (const TileId tile : tiles) succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile), compression)));
    succeed(writer.set_state(id, LayerState::kComplete));
    succeed(writer.finish());
  }
};

TEST_F(ValidateTest, FindsNothingInAWholeStore) {
  build({tile_at(0, 0, 0), tile_at(1, 1, 0), tile_at(2, 2, 1)});
  EXPECT_THAT(numbers_in(path), IsEmpty());
  const auto report = value_of(validate(path));
  EXPECT_TRUE(report.ok());
  EXPECT_EQ(report.tiles_checked, 3U);
}

// Every commit leaves some; a fresh store is not worth a remark for it.
TEST_F(ValidateTest, GarbageIsWorthAWordWhenPackingIsWorthIt) {
  build({tile_at(0, 0, 0)});
  const auto fresh = value_of(validate(path));
  EXPECT_THAT(fresh.findings, IsEmpty());
  EXPECT_GT(fresh.garbage_bytes, 0U);
  EXPECT_EQ(fresh.garbage_bytes + fresh.bytes_checked, std::filesystem::file_size(path));

  layer = small_layer("large", TexelFormat::kRgba8, 8, 1);
  StoreWriter writer = value_of(StoreWriter::open(path));
  const LayerId id = value_of(writer.add_layer(layer));
  for (int version = 0; version < 6; ++version) {
    succeed(writer.put(id, tile_at(0, 0, 0), encoded(tile_bytes(layer, tile_at(0, 0, 0), version))));
    succeed(writer.commit());
    const auto report = value_of(validate(path));
    EXPECT_EQ(std::ranges::count(report.findings, 109, &Finding::number), report.garbage_bytes > (1 << 20) ? 1 : 0) << report.garbage_bytes;
  }
  EXPECT_GT(value_of(validate(path)).garbage_bytes, 1U << 20);
}

TEST_F(ValidateTest, ASampleChecksSomeTilesAndTheSameOnesForTheSameSeed) {
  layer = small_layer("color", TexelFormat::kRgb8, 2, 7);
  std::vector<TileId> tiles;
  for (int level = 0; level <= 7; ++level)
    for (std::uint32_t y = 0; y < 1U << level; ++y)
      for (std::uint32_t x = 0; x < 1U << level; ++x) tiles.push_back(tile_at(level, x, y));
  build(tiles);
  const auto report = value_of(validate(path, {.sample_tiles = 500}));
  EXPECT_TRUE(report.ok());
  EXPECT_TRUE(report.is_sampled);
  EXPECT_THAT(report.findings, IsEmpty()) << "garbage is not looked for";
  EXPECT_EQ(report.tiles_in_store, tiles.size());
  EXPECT_LE(report.tiles_checked, 500U);
  EXPECT_GT(report.tiles_checked, 450U) << "few of them twice";
  EXPECT_LT(report.bytes_checked, std::filesystem::file_size(path) / 4);
  EXPECT_EQ(value_of(validate(path, {.sample_tiles = 500})).bytes_checked, report.bytes_checked);

  const auto whole = value_of(validate(path, {.sample_tiles = tiles.size()}));
  EXPECT_FALSE(whole.is_sampled);
  EXPECT_EQ(whole.tiles_checked, tiles.size());
}

TEST_F(ValidateTest, ASampleFindsWhatItMeets) {
  layer = small_layer("color", TexelFormat::kRgb8, 2, 6);
  std::vector<TileId> tiles;
  for (int level = 0; level <= 6; ++level)
    for (std::uint32_t y = 0; y < 1U << level; ++y)
      for (std::uint32_t x = 0; x < 1U << level; ++x)
        if (level != 5 || x % 2 == 0) tiles.push_back(tile_at(level, x, y));
  build(tiles);
  // Half of level 6 has no parent.
  std::size_t orphans = 0;
  for (const Finding& finding : value_of(validate(path, {.sample_tiles = 200})).findings) orphans += finding.number == 404 ? 1 : 0;
  EXPECT_GT(orphans, 20U);
  EXPECT_LT(orphans, 150U);

  // A leaf of level 6 that is damaged is one finding, however often the sample comes by; so is every tile
  // that is.
  Bytes bytes = read_file(path);
  for (std::uint64_t at = kLogStart; at + kRecordHeaderBytes <= bytes.size(); at += kRecordAlignment) {
    if (get<std::uint32_t>(bytes, at + 8) != 0x43525456) continue;
    const bool is_tile = get<std::uint8_t>(bytes, at + 12) == static_cast<std::uint8_t>(RecordType::kTile);
    const std::uint64_t key = get<std::uint64_t>(bytes, at + 24);
    const bool is_leaf = get<std::uint8_t>(bytes, at + 12) == static_cast<std::uint8_t>(RecordType::kPage) &&
                         key == record_key(LayerId{0}, Level{6}, 1024) && get<std::uint8_t>(bytes, at + kRecordHeaderBytes + 2) == 0;
    if (is_leaf || (is_tile && key >> 46 == 5)) bytes[at + kRecordHeaderBytes + 20] ^= std::byte{1};
  }
  write_file(path, bytes);
  std::size_t pages = 0;
  std::set<std::string> damaged_tiles;
  for (const Finding& finding : value_of(validate(path, {.sample_tiles = 1000})).findings) {
    pages += finding.number == 302 ? 1 : 0;
    if (finding.number != 401) continue;
    EXPECT_THAT(finding.place, HasSubstr("level 5"));
    EXPECT_TRUE(damaged_tiles.insert(finding.place).second);
  }
  EXPECT_EQ(pages, 1U);
  EXPECT_GT(damaged_tiles.size(), 20U);
}

TEST_F(ValidateTest, AMissingFileIsAnErrorNotAFinding) { EXPECT_EQ(validate(path).error().code, ErrorCode::kIo); }

TEST_F(ValidateTest, AnAbsentParentIsAnErrorNamedByItsTile) {
  build({tile_at(0, 0, 0), tile_at(2, 3, 1)});
  const auto findings = findings_in(path);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].number, 404);
  EXPECT_TRUE(findings[0].is_error);
  EXPECT_EQ(findings[0].place, "layer color, level 2, tile 3,1");
}

TEST_F(ValidateTest, AnUnfinishedLayerMayLackParentsAndIsStillValid) {
  StoreWriter writer = value_of(StoreWriter::create(path, {}));
  const LayerId id = value_of(writer.add_layer(layer));
  succeed(writer.put(id, tile_at(3, 5, 1), encoded(tile_bytes(layer, tile_at(3, 5, 1)))));
  succeed(writer.finish());
  EXPECT_THAT(numbers_in(path), ElementsAre(501));
  EXPECT_TRUE(value_of(validate(path)).ok());
}

TEST_F(ValidateTest, CountsTilesOutsideTheDataOnce) {
  layer.data = {0, 0, 30, 30};
  build({tile_at(0, 0, 0), tile_at(1, 0, 0), tile_at(1, 1, 1), tile_at(1, 1, 0)});
  const auto findings = findings_in(path);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].number, 503);
  EXPECT_FALSE(findings[0].is_error);
  EXPECT_THAT(findings[0].sentence, HasSubstr("2 tiles"));
}

TEST_F(ValidateTest, APayloadThatDoesNotDecodeIsFoundWhenAskedFor) {
  layer.tile_exponent = 5;
  layer.data = {0, 0, 1, 1};
  build({tile_at(0, 0, 0)}, {Codec::kZstd, 1});
  Bytes bytes = read_file(path);
  const auto lookup = value_of(value_of(StoreReader::open(path)).lookup(LayerId{0}, tile_at(0, 0, 0)));
  ASSERT_EQ(lookup.codec, Codec::kZstd);
  bytes[lookup.offset + kRecordHeaderBytes] ^= std::byte{0xFF};  // zstd's own magic
  reseal(bytes);
  write_file(path, bytes);
  EXPECT_THAT(numbers_in(path), ElementsAre(402));
  EXPECT_THAT(numbers_in(path, {.decode_tiles = false}), IsEmpty());
}

TEST_F(ValidateTest, PaddingMustBeZero) {
  build({tile_at(0, 0, 0)});
  Bytes bytes = read_file(path);
  bytes.back() = std::byte{1};  // the catalog's padding
  write_file(path, bytes);
  EXPECT_THAT(numbers_in(path), ElementsAre(403));
}

TEST_F(ValidateTest, ADamagedSuperblockIsWorthKnowingAndNoError) {
  build({tile_at(0, 0, 0)});
  const Bytes whole = read_file(path);
  for (const std::uint64_t slot : {0, 1}) {
    Bytes bytes = whole;
    bytes[superblock_offset(slot) + 50] ^= std::byte{1};
    write_file(path, bytes);
    const auto findings = findings_in(path);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].number, 101);
    EXPECT_FALSE(findings[0].is_error);
    EXPECT_THAT(findings[0].sentence, HasSubstr("nothing is lost"));
  }
}

TEST_F(ValidateTest, AReportOfARuinedStoreStaysShort) {
  layer = small_layer("color", TexelFormat::kRgb8, 2, 6);
  std::vector<TileId> tiles;
  for (std::uint32_t i = 0; i < 1500; ++i) tiles.push_back(tile_at(6, i % 64, i / 64));
  build(tiles);  // not one has a parent
  const auto report = value_of(validate(path));
  EXPECT_LE(report.findings.size(), 1001U);
  EXPECT_EQ(report.findings.back().number, 199);
  EXPECT_FALSE(report.ok());
}

TEST_F(ValidateTest, ReportsItsProgress) {
  layer = small_layer("color", TexelFormat::kRgb8, 2, 6);
  std::vector<TileId> tiles;
  for (std::uint32_t i = 0; i < 1024; ++i) tiles.push_back(tile_at(6, i % 64, i / 64));
  build(tiles);
  std::vector<std::uint64_t> seen;
  ASSERT_TRUE(validate(path, {.progress = [&](std::uint64_t done, std::uint64_t total) {
                         EXPECT_EQ(total, 1024U);
                         seen.push_back(done);
                       }}));
  EXPECT_THAT(seen, ElementsAre(256, 512, 768, 1024));
}

}  // namespace
}  // namespace vt::store
