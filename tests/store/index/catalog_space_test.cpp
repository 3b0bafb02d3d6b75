// Catalogs take turns in two places, and nothing else in the file is ever overwritten, whatever a superblock
// says.
#include "store/index/catalog_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "store/format/layout.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

Superblock newest_of(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  return choose_superblock(std::span(bytes).first(kLogStart), bytes.size()).value().newest;
}

struct CatalogSpaceTest : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";
  LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 1);

  // A commit of its own, which is what a program that is run once does.
  void change_metadata(std::size_t bytes) {
    StoreWriter writer = value_of(StoreWriter::open(path, {.sync = false}));
    succeed(writer.set_metadata(LayerId{0}, std::string(bytes - 1, ' ') + static_cast<char>('a' + ++changes_ % 20)));
    succeed(writer.finish());
    ASSERT_TRUE(value_of(validate(path)).ok());
  }
  void build() {
    StoreWriter writer = value_of(StoreWriter::create(path, {}, {.sync = false}));
    const LayerId id = value_of(writer.add_layer(layer));
    for (const TileId tile : {tile_at(0, 0, 0), tile_at(1, 1, 1)}) succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile))));
    succeed(writer.finish());
  }

 private:
  int changes_ = 0;
};

TEST_F(CatalogSpaceTest, ManyCommitsOfOneStoreNeedTwoPlaces) {
  build();
  for (int i = 0; i < 3; ++i) change_metadata(100);
  const std::uint64_t bytes = std::filesystem::file_size(path);
  std::set<std::uint64_t> places;
  for (int i = 0; i < 50; ++i) {
    change_metadata(100);
    places.insert(newest_of(path).catalog.offset);
  }
  EXPECT_EQ(std::filesystem::file_size(path), bytes);
  EXPECT_EQ(places.size(), 2U);
}

// As 200 runs of a builder with a few commits each; every layer has texts and working state of its own.
TEST_F(CatalogSpaceTest, ManySmallLayersAreNotBuriedUnderOldCatalogs) {
  value_of(StoreWriter::create(path, {}, {.sync = false}));
  const std::string text(1500, 'x');
  for (int number = 0; number < 200; ++number) {
    StoreWriter writer = value_of(StoreWriter::open(path, {.sync = false}));
    layer.name = "layer " + std::to_string(number);
    const LayerId id = value_of(writer.add_layer(layer));
    succeed(writer.commit());
    succeed(writer.put(id, {}, encoded(tile_bytes(layer, {}, number))));
    succeed(writer.set_metadata(id, text));
    succeed(writer.commit());
    succeed(writer.set_state(id, LayerState::kComplete));
    succeed(writer.finish());
  }
  const std::uint64_t catalog = newest_of(path).catalog.record_bytes();
  EXPECT_GT(catalog, 300000U);
  // Appended one after the other, they were 600 times half of the last one. Places that grow by half are
  // three times as much as the last ones, which have half of it to spare; and there are two.
  const std::uint64_t others = 200 * (128 + 256 + 4096);
  EXPECT_LT(std::filesystem::file_size(path), 2 * 3 * (catalog + catalog / 2) + others);
  EXPECT_TRUE(value_of(validate(path)).ok());
  EXPECT_EQ(read_all(value_of(StoreReader::open(path))).size(), 200U);
}

TEST_F(CatalogSpaceTest, WhatASuperblockSaysIsLookedAtBeforeItIsOverwritten) {
  build();
  for (int i = 0; i < 3; ++i) change_metadata(100);
  const Contents truth = read_all(value_of(StoreReader::open(path)));
  const Bytes good = read_file(path);
  const Superblock newest = newest_of(path);
  ASSERT_GT(newest.spare_catalog.bytes, 0U);
  const auto forge = [&](const Extent& spare, std::uint64_t catalog_space) {
    Bytes bytes = good;
    for (const std::size_t slot : {std::size_t{0}, kSuperblockBytes}) {
      put<std::uint64_t>(bytes, slot + 88, catalog_space);
      put<std::uint64_t>(bytes, slot + 96, spare.offset);
      put<std::uint64_t>(bytes, slot + 104, spare.bytes);
    }
    reseal(bytes);
    write_file(path, bytes);
  };
  std::vector<Extent> spares = {newest.spare_catalog, {newest.catalog.offset, newest.catalog.record_bytes()}};
  for (std::uint64_t at = 0; at <= newest.file_end + 64; at += 64)
    for (const std::uint64_t bytes : {std::uint64_t{64}, std::uint64_t{1024}, newest.file_end - kLogStart, ~std::uint64_t{63}})
      spares.push_back({at, bytes});
  spares.push_back({newest.spare_catalog.offset + 1, 1000});
  for (const Extent& spare : spares) {
    for (const std::uint64_t space : {newest.catalog_space, newest.file_end - newest.catalog.offset, ~std::uint64_t{63}}) {
      forge(spare, space);
      for (int i = 0; i < 3; ++i) ASSERT_NO_FATAL_FAILURE(change_metadata(100)) << spare.offset << " " << spare.bytes << " " << space;
      ASSERT_EQ(read_all(value_of(StoreReader::open(path))), truth) << spare.offset << " " << spare.bytes << " " << space;
    }
  }
}

// Bytes behind an old catalog that are no zeros belong to somebody.
TEST_F(CatalogSpaceTest, ASparePlaceWithAnythingElseInItIsLeftAlone) {
  for (const bool is_behind : {false, true}) {
    std::filesystem::remove(path);
    build();
    for (const std::size_t size : {100, 200, 300, 300, 100}) change_metadata(size);
    const Extent spare = newest_of(path).spare_catalog;
    ASSERT_GT(spare.bytes, 400U);
    const std::uint64_t at = is_behind ? spare.offset + spare.bytes - 1 : spare.offset + 40;
    Bytes bytes = read_file(path);
    bytes[at] ^= std::byte{1};
    write_file(path, bytes);
    change_metadata(100);
    EXPECT_NE(newest_of(path).catalog.offset, spare.offset);
    EXPECT_EQ(read_file(path)[at], bytes[at]);
  }
}

}  // namespace
}  // namespace vt::store
