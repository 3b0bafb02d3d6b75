#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "store/format/layout.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "tests/store/store_support.h"
#include "tests/support/format_lists.h"

namespace vt::store {
namespace {

using namespace test;
using testing::HasSubstr;
using vt::test::texture_formats;

TEST(Store, KeepsEveryFormatRawAndCompressed) {
  const TempFolder folder;
  Contents truth;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  for (const TexelFormat format : texture_formats()) {
    for (const Compression compression : {Compression{}, Compression{Codec::kZstd, 3}}) {
      const std::string name = std::string(format_info(format).name) + (compression.codec == Codec::kRaw ? " raw" : " zstd");
      const LayerInfo layer = small_layer(name, format, 4, 2);
      const LayerId id = value_of(writer.add_layer(layer));
      for (const TileId tile : {tile_at(0, 0, 0), tile_at(1, 1, 0), tile_at(2, 3, 2), tile_at(2, 0, 3)}) {
        const Bytes bytes = tile_bytes(layer, tile);
        succeed(writer.put(id, tile, encoded(bytes, compression)));
        truth[{name, tile}] = bytes;
      }
    }
  }
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_EQ(reader.layers().size(), 2 * texture_formats().size());
  EXPECT_EQ(read_all(reader), truth);
}

// In Morton order, whatever lies in the file and whatever only in memory yet.
TEST(Store, AWriterNamesItsTilesOneAfterAnother) {
  const TempFolder folder;
  const LayerInfo layer = small_layer("a", TexelFormat::kRgb8, 2, 12);  // pages of three heights
  const std::vector<std::byte> block(3, std::byte{7});
  std::mt19937_64 random(1);
  std::map<std::uint64_t, TileId> wanted;
  const auto expect_all = [&](const StoreWriter& writer, LayerId id, Level level) {
    std::vector<TileId> found;
    std::optional<TileId> tile;
    while ((tile = value_of(writer.next_tile(id, level, tile)))) found.push_back(*tile);
    std::vector<TileId> all;
    for (const auto& [morton, one] : wanted) all.push_back(one);
    EXPECT_EQ(found, all);
  };
  LayerId id;
  {
    StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
    id = value_of(writer.add_layer(layer));
    expect_all(writer, id, Level{12});
    for (int round = 0; round < 3; ++round) {
      for (int i = 0; i < 40; ++i) {
        // Neighbours, corners, and tiles far from all others.
        const auto at = [&] {
          return static_cast<std::uint32_t>(i % 4 == 0 ? random() % 2 * 4095 : i % 4 == 1 ? random() % 40 : random() % 4096);
        };
        const TileId tile = tile_at(12, at(), at());
        succeed(writer.put_constant(id, tile, block));
        wanted[morton_code(tile.x, tile.y)] = tile;
      }
      const TileId gone = wanted.begin()->second;
      succeed(writer.remove(id, gone));
      wanted.erase(wanted.begin());
      expect_all(writer, id, Level{12});
      succeed(writer.commit());
      expect_all(writer, id, Level{12});
    }
    EXPECT_FALSE(value_of(writer.next_tile(id, Level{11}, std::nullopt)));
    EXPECT_EQ(writer.next_tile(id, Level{13}, std::nullopt).error().code, ErrorCode::kUsage);
  }
  expect_all(value_of(StoreWriter::open(folder / "a.vts")), id, Level{12});
}

TEST(Store, KeepsEveryFieldOfALayerAndOfTheDataset) {
  const TempFolder folder;
  const StoreDescription description{.area = {.west = 179.0, .south = -12.25, .east = 181.5, .north = -10.0},
                                     .metadata_json = R"({"crs":"EPSG:4326"})"};
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", description));
  LayerInfo info;
  info.name = "hauteur à Ώ";
  info.channel = ChannelType::kElevation;
  info.format = TexelFormat::kR32Float;
  info.transfer = Transfer::kSrgb;
  info.tile_exponent = 5;
  info.finest = {3};
  info.data = {3, 5, 200, 100};
  info.grid = {.origin_x = 179.1, .origin_y = -10.1, .step_x = 1e-3, .step_y = 2e-3};
  info.source_nodata = -32768.0;
  info.components = {{{0.5, -500.0}, {1e-3, 0.0}, {-2.0, 7.0}, {1e300, -1e300}}};
  info.metadata_json = R"({"unit":"m"})";
  const LayerId id = value_of(writer.add_layer(info));
  LayerInfo carry = info;
  carry.name = "carry";
  carry.role = LayerRole::kCarry;
  carry.owner = id;
  ASSERT_TRUE(writer.add_layer(carry));
  succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.finish());

  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_EQ(reader.description().area, description.area);
  EXPECT_EQ(reader.description().metadata_json, description.metadata_json);
  EXPECT_THAT(reader.uuid(), testing::MatchesRegex("[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}"));
  const LayerInfo* back = reader.find_layer(info.name);
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->channel, info.channel);
  EXPECT_EQ(back->format, info.format);
  EXPECT_EQ(back->transfer, info.transfer);
  EXPECT_EQ(back->role, LayerRole::kTexture);
  EXPECT_EQ(back->state, LayerState::kComplete);
  EXPECT_EQ(back->tile_exponent, info.tile_exponent);
  EXPECT_EQ(back->finest, info.finest);
  EXPECT_EQ(back->data, info.data);
  EXPECT_EQ(back->grid, info.grid);
  EXPECT_EQ(back->source_nodata, info.source_nodata);
  EXPECT_EQ(back->components, info.components);
  EXPECT_EQ(back->metadata_json, info.metadata_json);
  const LayerInfo* carried = reader.find_layer("carry");
  ASSERT_NE(carried, nullptr);
  EXPECT_EQ(carried->role, LayerRole::kCarry);
  EXPECT_EQ(carried->owner, id);
  EXPECT_EQ(carried->state, LayerState::kBuilding);
  EXPECT_EQ(reader.find_layer("no such"), nullptr);
  EXPECT_EQ(reader.find_layer(LayerId{77}), nullptr);
}

TEST(Store, ExpandsConstantsAndSharesTheirRecord) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("c", TexelFormat::kRgb8, 4, 5);
  const LayerId id = value_of(writer.add_layer(layer));
  const Bytes blue = {std::byte{1}, std::byte{2}, std::byte{250}};
  const Bytes red = {std::byte{200}, std::byte{2}, std::byte{3}};
  for (std::uint32_t x = 0; x < 32; ++x) succeed(writer.put_constant(id, tile_at(5, x, 7), x % 2 == 0 ? blue : red));
  Bytes out(layer.tile_payload_bytes());
  succeed(writer.read(id, tile_at(5, 3, 7), out));
  EXPECT_EQ(out[0], red[0]);
  succeed(writer.finish());

  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  const auto first = value_of(reader.lookup(id, tile_at(5, 0, 7)));
  const auto third = value_of(reader.lookup(id, tile_at(5, 2, 7)));
  EXPECT_EQ(first.kind, TileKind::kConstant);
  EXPECT_EQ(first.offset, third.offset);
  EXPECT_NE(first.offset, value_of(reader.lookup(id, tile_at(5, 1, 7))).offset);
  succeed(reader.read(id, tile_at(5, 31, 7), out));
  for (std::size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i], red[i % 3]);
  EXPECT_EQ(reader.find_layer(id)->tiles, 32U);
  EXPECT_EQ(reader.find_layer(id)->constant_tiles, 32U);
  EXPECT_EQ(reader.find_layer(id)->stored_bytes, 32U * 64);
}

TEST(Store, SparseDeepTilesAreFoundAndTheirNeighboursAreAbsent) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("deep", TexelFormat::kRgb8, 2, 23);
  const LayerId id = value_of(writer.add_layer(layer));
  std::mt19937 random(7);
  Contents truth;
  for (int i = 0; i < 300; ++i) {
    const int level = static_cast<int>(random() % 24);
    const TileId tile = tile_at(level, static_cast<std::uint32_t>(random()) & ((1U << level) - 1),
                                static_cast<std::uint32_t>(random()) & ((1U << level) - 1));
    truth[{layer.name, tile}] = tile_bytes(layer, tile);
    succeed(writer.put(id, tile, encoded(truth[{layer.name, tile}])));
  }
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_EQ(reader.find_layer(id)->tiles, truth.size());
  for (const auto& [name, bytes] : truth) {
    Bytes out(bytes.size());
    succeed(reader.read(id, name.second, out));
    EXPECT_EQ(out, bytes);
    const TileId beside{name.second.level, name.second.x ^ 1, name.second.y};
    if (name.second.level.value > 0 && !truth.contains({layer.name, beside})) {
      EXPECT_EQ(value_of(reader.lookup(id, beside)).kind, TileKind::kAbsent);
      EXPECT_EQ(reader.read(id, beside, out).error().code, ErrorCode::kNotFound);
    }
  }
}

TEST(Store, NearestPresentClimbsToTheFirstAncestor) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 2, 8);
  const LayerId id = value_of(writer.add_layer(layer));
  const TileId coarse = tile_at(2, 1, 3);
  succeed(writer.put(id, coarse, encoded(tile_bytes(layer, coarse))));
  succeed(writer.commit());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_EQ(value_of(reader.nearest_present(id, tile_at(8, 64, 255))), coarse);
  EXPECT_EQ(value_of(reader.nearest_present(id, tile_at(2, 1, 3))), coarse);
  EXPECT_EQ(value_of(reader.nearest_present(id, tile_at(12, 64 << 4, 255 << 4))), coarse);
  EXPECT_EQ(value_of(reader.nearest_present(id, tile_at(8, 0, 0))), std::nullopt);
}

TEST(Store, ReopensAndAppends) {
  const TempFolder folder;
  const LayerInfo layer = small_layer("l", TexelFormat::kRgba8, 3, 6);
  Contents truth;
  succeed(value_of(StoreWriter::create(folder / "a.vts", {})).finish());
  for (int session = 0; session < 6; ++session) {
    StoreWriter writer = value_of(StoreWriter::open(folder / "a.vts"));
    const LayerId id = session == 0 ? value_of(writer.add_layer(layer)) : writer.find_layer("l")->id;
    for (std::uint32_t i = 0; i < 40; ++i) {
      const TileId tile = tile_at(6, (i * 7 + static_cast<std::uint32_t>(session) * 11) % 64, i);
      truth[{"l", tile}] = tile_bytes(layer, tile, session);
      succeed(writer.put(id, tile, encoded(truth[{"l", tile}], {Codec::kZstd, 1})));
      EXPECT_TRUE(writer.contains(id, tile));
    }
    const TileId gone = truth.begin()->first.second;
    succeed(writer.remove(id, gone));
    EXPECT_FALSE(writer.contains(id, gone));
    truth.erase({"l", gone});
    succeed(writer.finish());
    EXPECT_EQ(writer.put(id, gone, encoded(tile_bytes(layer, gone))).error().code, ErrorCode::kUsage);
    const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
    EXPECT_EQ(read_all(reader), truth);
    EXPECT_EQ(reader.find_layer("l")->tiles, truth.size());
  }
}

TEST(Store, AReaderSeesOneGenerationWhateverTheWriterDoes) {
  const TempFolder folder;
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 3, 3);
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerId id = value_of(writer.add_layer(layer));
  std::vector<std::pair<StoreReader, Contents>> snapshots;
  Contents truth;
  for (int version = 0; version < 8; ++version) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      const TileId tile = tile_at(3, i, static_cast<std::uint32_t>(version) % 3);
      truth[{"l", tile}] = tile_bytes(layer, tile, version);
      succeed(writer.put(id, tile, encoded(truth[{"l", tile}])));
    }
    if (version > 0) {  // not committed, not visible
      EXPECT_EQ(read_all(value_of(StoreReader::open(folder / "a.vts"))), snapshots.back().second);
    }
    succeed(writer.commit());
    snapshots.emplace_back(value_of(StoreReader::open(folder / "a.vts")), truth);
  }
  for (const auto& [reader, contents] : snapshots) EXPECT_EQ(read_all(reader), contents);
}

TEST(Store, RemovingALayerTakesItsCarryLayersAndFreesTheName) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 3, 3);
  const LayerId id = value_of(writer.add_layer(layer));
  LayerInfo carry = small_layer("carry", TexelFormat::kRgba32Float, 3, 3);
  carry.role = LayerRole::kCarry;
  carry.owner = id;
  ASSERT_TRUE(writer.add_layer(carry));
  const LayerInfo other = small_layer("other", TexelFormat::kRgb8, 3, 3);
  const LayerId other_id = value_of(writer.add_layer(other));
  const TileId tile = tile_at(1, 1, 1);
  succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile))));
  succeed(writer.put(other_id, tile, encoded(tile_bytes(other, tile))));
  succeed(writer.commit());
  succeed(writer.remove_layer(id));
  EXPECT_EQ(writer.layers().size(), 1U);
  const LayerId again = value_of(writer.add_layer(layer));
  EXPECT_FALSE(writer.contains(again, tile));
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  const Contents truth = {{{"other", tile}, tile_bytes(other, tile)}};
  EXPECT_EQ(read_all(reader), truth);
}

TEST(Store, RefusesASecondWriterAndSaysWhy) {
  const TempFolder folder;
  const StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const auto second = StoreWriter::open(folder / "a.vts");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kExists);
  EXPECT_THAT(second.error().message, HasSubstr("another program is writing"));
}

TEST(Store, NeverReplacesAFile) {
  const TempFolder folder;
  write_file(folder / "a.vts", Bytes(3));
  EXPECT_EQ(StoreWriter::create(folder / "a.vts", {}).error().code, ErrorCode::kExists);
  EXPECT_EQ(read_file(folder / "a.vts"), Bytes(3));
}

TEST(Store, OpeningWhatIsNotAStoreNamesTheFileAndTheReason) {
  const TempFolder folder;
  EXPECT_EQ(StoreReader::open(folder / "none.vts").error().code, ErrorCode::kIo);
  EXPECT_EQ(StoreWriter::open(folder / "none.vts").error().code, ErrorCode::kIo);
  write_file(folder / "empty.vts", {});
  write_file(folder / "text.vts", Bytes(20000, std::byte{'x'}));
  for (const char* name : {"empty.vts", "text.vts"}) {
    const auto reader = StoreReader::open(folder / name);
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().code, ErrorCode::kInvalidData);
    EXPECT_THAT(reader.error().message, HasSubstr(name));
    EXPECT_THAT(reader.error().message, HasSubstr("not a tile store"));
  }
  EXPECT_FALSE(StoreReader::open(folder / "."));
}

TEST(Store, RefusesLayersOutOfRangeBeforeAnythingIsWritten) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo good = small_layer("good", TexelFormat::kRgb8, 8, 4);
  ASSERT_TRUE(writer.add_layer(good));
  EXPECT_EQ(writer.add_layer(good).error().code, ErrorCode::kExists);
  const auto refused = [&](auto change) {
    LayerInfo info = small_layer("bad", TexelFormat::kRgb8, 8, 4);
    change(info);
    const auto added = writer.add_layer(info);
    ASSERT_FALSE(added);
    EXPECT_EQ(added.error().code, ErrorCode::kInvalidData) << added.error().message;
  };
  refused([](LayerInfo& l) { l.name = ""; });
  refused([](LayerInfo& l) { l.name = std::string(64, 'x'); });
  refused([](LayerInfo& l) { l.name = "a\nb"; });
  refused([](LayerInfo& l) { l.name = "\xC0\x80"; });
  refused([](LayerInfo& l) { l.tile_exponent = 1; });
  refused([](LayerInfo& l) { l.tile_exponent = 13; });
  refused([](LayerInfo& l) { l.finest = {24}; });
  refused([](LayerInfo& l) { l.tile_exponent = 12, l.finest = {20}; });
  refused([](LayerInfo& l) { l.data.width = 0; });
  refused([](LayerInfo& l) { l.data.x = -1; });
  refused([](LayerInfo& l) { l.data.width += 1; });
  refused([](LayerInfo& l) { l.grid.step_x = 0.0; });
  refused([](LayerInfo& l) { l.grid.origin_y = std::numeric_limits<double>::infinity(); });
  refused([](LayerInfo& l) { l.channel = static_cast<ChannelType>(99); });
  refused([](LayerInfo& l) { l.format = static_cast<TexelFormat>(99); });
  refused([](LayerInfo& l) { l.role = LayerRole::kCarry, l.owner = {9}; });
  refused([](LayerInfo& l) { l.metadata_json = "\xFF"; });
  refused([](LayerInfo& l) { l.components[2].scale = 0.0; });
  refused([](LayerInfo& l) { l.components[3].offset = std::nan(""); });
  refused([](LayerInfo& l) { l.format = TexelFormat::kR32Float, l.zero_is_nodata = true; });
  refused([](LayerInfo& l) { l.format = TexelFormat::kBlob; });
  EXPECT_EQ(writer.layers().size(), 1U);
}

TEST(Store, RefusesTilesOutsideThePyramidAndPayloadsOfAnotherSize) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 3, 4);
  const LayerId id = value_of(writer.add_layer(layer));
  const EncodedPayload good = encoded(tile_bytes(layer, {}));
  EXPECT_EQ(writer.put(id, tile_at(4, 16, 0), good).error().code, ErrorCode::kUsage);
  EXPECT_EQ(writer.put(id, tile_at(5, 0, 0), good).error().code, ErrorCode::kUsage);
  EXPECT_EQ(writer.put(LayerId{3}, tile_at(0, 0, 0), good).error().code, ErrorCode::kUsage);
  EXPECT_EQ(writer.put(id, tile_at(0, 0, 0), encoded(Bytes(10))).error().code, ErrorCode::kUsage);
  EXPECT_EQ(writer.put_constant(id, tile_at(0, 0, 0), Bytes(4)).error().code, ErrorCode::kUsage);
  succeed(writer.put(id, tile_at(0, 0, 0), good));
  succeed(writer.finish());
}

TEST(Store, AnUnchangedStoreIsNotWrittenAgain) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  ASSERT_TRUE(writer.add_layer(small_layer("l", TexelFormat::kRgb8, 3, 4)));
  succeed(writer.commit());
  const std::uint64_t bytes = writer.file_bytes();
  const std::uint64_t generation = writer.generation();
  succeed(writer.commit());
  succeed(writer.finish());
  EXPECT_EQ(std::filesystem::file_size(folder / "a.vts"), bytes);
  EXPECT_EQ(value_of(StoreReader::open(folder / "a.vts")).generation(), generation);
}

// More leaves than the writer keeps in memory, touched in an order that makes it drop and fetch them again
// and again.
TEST(Store, AnIndexLargerThanTheCacheSurvivesRandomOrder) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}, {.sync = false}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 2, 12);
  const LayerId id = value_of(writer.add_layer(layer));
  std::mt19937 random(3);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> truth;
  for (int i = 0; i < 6000; ++i) {
    const std::uint32_t x = random() % 4096;
    const std::uint32_t y = random() % 4096;
    truth[{x, y}] = i;
    succeed(writer.put(id, tile_at(12, x, y), encoded(tile_bytes(layer, tile_at(12, x, y), i))));
    if (i == 3000) succeed(writer.commit());
  }
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  EXPECT_EQ(reader.find_layer(id)->tiles, truth.size());
  Bytes out(layer.tile_payload_bytes());
  for (const auto& [place, version] : truth) {
    const TileId tile = tile_at(12, place.first, place.second);
    succeed(reader.read(id, tile, out));
    ASSERT_EQ(out, tile_bytes(layer, tile, version));
  }
}

TEST(Morton, IsItsOwnInverseAndInterleavesColumnsFirst) {
  EXPECT_EQ(morton_code(1, 0), 1U);
  EXPECT_EQ(morton_code(0, 1), 2U);
  EXPECT_EQ(morton_code(0x7FFFFF, 0x7FFFFF), (std::uint64_t{1} << 46) - 1);
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const TileId tile = tile_at(23, static_cast<std::uint32_t>(random()) >> 9, static_cast<std::uint32_t>(random()) >> 9);
    EXPECT_EQ(tile_from_morton(tile.level, morton_code(tile.x, tile.y)), tile);
  }
}

}  // namespace
}  // namespace vt::store
