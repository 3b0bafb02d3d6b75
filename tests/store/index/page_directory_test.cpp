// The reader's memory of checked pages, through the reader: look-ups one by one and many at once, against
// what was written.
#include "store/index/page_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <thread>

#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

// Levels 0 to 7 whole but for a few holes, and scattered tiles down to level 23: full leaves, full inner
// pages and sparse ones.
struct LookupTest : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";
  LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 2, 23);
  LayerId id;
  std::map<TileId, TileKind> truth;
  std::vector<TileId> asked;  // those that are there and many that are not, in random order

  void SetUp() override {
    StoreWriter writer = value_of(StoreWriter::create(path, {}, {.sync = false}));
    id = value_of(writer.add_layer(small_layer("other", TexelFormat::kRgb8, 2, 9)));
    for (std::uint32_t i = 0; i < 64; ++i) succeed(writer.put_constant(id, tile_at(9, 8 * i, 511 - i), Bytes(3)));
    id = value_of(writer.add_layer(layer));
    std::mt19937 random(9);
    const auto put = [&](TileId tile) {
      if (random() % 8 == 0) {
        succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile))));
        truth[tile] = TileKind::kStored;
      } else {
        succeed(writer.put_constant(id, tile, Bytes(3, static_cast<std::byte>(tile.x))));
        truth[tile] = TileKind::kConstant;
      }
    };
    for (int level = 0; level <= 7; ++level)
      for (std::uint32_t y = 0; y < 1U << level; ++y)
        for (std::uint32_t x = 0; x < 1U << level; ++x)
          if (level != 7 || (x * 31 + y * 17) % 1000 != 0) put(tile_at(level, x, y));
    for (int i = 0; i < 400; ++i) {
      const int level = 8 + static_cast<int>(random() % 16);
      const std::uint32_t mask = (1U << level) - 1;
      put(tile_at(level, static_cast<std::uint32_t>(random()) & mask, static_cast<std::uint32_t>(random()) & mask));
    }
    succeed(writer.finish());

    for (const auto& [tile, kind] : truth) {
      asked.push_back(tile);
      asked.push_back({tile.level, tile.x ^ 1, tile.y});
      asked.push_back({tile.level, tile.y, tile.x});
    }
    for (const TileId outside : {tile_at(3, 8, 0), tile_at(0, 0, 1), tile_at(24, 0, 0), tile_at(255, 1, 1)}) asked.push_back(outside);
    std::shuffle(asked.begin(), asked.end(), random);
  }
  TileKind truth_of(TileId tile) const {
    const auto found = truth.find(tile);
    return found == truth.end() ? TileKind::kAbsent : found->second;
  }
};

TEST_F(LookupTest, FindsEveryTileColdAndWarmOneByOneAndManyAtOnce) {
  const StoreReader one_by_one = value_of(StoreReader::open(path));
  const StoreReader at_once = value_of(StoreReader::open(path));
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<TileLookup> many(asked.size());
    succeed(at_once.lookup_many(id, asked, many));
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const TileLookup one = value_of(one_by_one.lookup(id, asked[i]));
      ASSERT_EQ(one.kind, truth_of(asked[i])) << "pass " << pass;
      ASSERT_EQ(one.kind, many[i].kind);
      ASSERT_EQ(one.offset, many[i].offset);
      ASSERT_EQ(one.stored_bytes, many[i].stored_bytes);
      ASSERT_EQ(one.codec, many[i].codec);
    }
  }
  succeed(at_once.lookup_many(id, {}, {}));
  EXPECT_EQ(at_once.lookup_many(LayerId{77}, {}, {}).error().code, ErrorCode::kUsage);
}

TEST_F(LookupTest, ManyThreadsMayFillOneReadersMemory) {
  const StoreReader reader = value_of(StoreReader::open(path));
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        std::vector<TileLookup> many(asked.size());
        EXPECT_TRUE(t % 2 == 1 || reader.lookup_many(id, asked, many));
        for (std::size_t i = 0; i < asked.size(); ++i) {
          const std::size_t at = (i + t * asked.size() / 4) % asked.size();
          EXPECT_EQ(reader.lookup(id, asked[at])->kind, truth_of(asked[at]));
        }
      });
  }
  StoreReader moved = value_of(StoreReader::open(folder / "a.vts"));
  moved = value_of(StoreReader::open(path));
  EXPECT_EQ(value_of(moved.lookup(id, tile_at(0, 0, 0))).kind, truth_of(tile_at(0, 0, 0)));
}

TEST_F(LookupTest, ADamagedPageIsNeverTrustedWhoeverAsks) {
  // The page that holds the first tile of level 7, and all pages after it in the file, lose a bit each: every
  // look-up that needs one says so, every time.
  const Bytes whole = read_file(path);
  std::vector<std::uint64_t> leaves;
  for (std::uint64_t at = kLogStart; at + kRecordHeaderBytes <= whole.size(); at += kRecordAlignment)
    if (get<std::uint32_t>(whole, at + 8) == 0x43525456 && get<std::uint8_t>(whole, at + 12) == 3 &&
        get<std::uint64_t>(whole, at + 24) >> 46 == (std::uint64_t{id.value} << 6 | 7))
      leaves.push_back(at);
  ASSERT_FALSE(leaves.empty());
  Bytes damaged = whole;
  for (const std::uint64_t at : leaves) damaged[at + kRecordHeaderBytes + 200] ^= std::byte{4};
  write_file(path, damaged);
  const StoreReader reader = value_of(StoreReader::open(path));
  for (int pass = 0; pass < 2; ++pass) {
    const auto one = reader.lookup(id, tile_at(7, 5, 5));
    ASSERT_FALSE(one);
    EXPECT_EQ(one.error().code, ErrorCode::kCorrupt);
    std::vector<TileLookup> many(2);
    const auto both = reader.lookup_many(id, std::vector<TileId>{tile_at(6, 1, 1), tile_at(7, 5, 5)}, many);
    ASSERT_FALSE(both);
    EXPECT_THAT(both.error().message, testing::HasSubstr("index page"));
    EXPECT_EQ(value_of(reader.lookup(id, tile_at(6, 1, 1))).kind, truth_of(tile_at(6, 1, 1)));
  }
}

}  // namespace
}  // namespace vt::store
