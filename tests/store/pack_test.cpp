#include "store/pack.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <random>
#include <set>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/validate.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A file's newest generation taken apart with layout.h alone: where every record lies, and what it is.
struct Record {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  RecordType type = RecordType::kTile;
  LayerId layer;
  TileId tile;     // of a page: the first one it can reach
  int height = 0;  // of a page
};
struct Anatomy {
  Superblock superblock;
  Catalog catalog;
  std::vector<Record> records;  // in the order of the file; shared ones once
};

void take_page(const Bytes& file, const CatalogLayer& layer, Level level, const Reference& page, int height, std::uint64_t first_morton,
               std::map<std::uint64_t, Record>& out) {
  const TileId first = tile_from_morton(level, first_morton);
  out[page.offset] = {page.offset, page.record_bytes(), RecordType::kPage, layer.info.id, first, height};
  const auto payload = std::span(file).subspan(page.offset + kRecordHeaderBytes, page.stored_bytes);
  for (int slot = 0; slot < kPageSlots; ++slot) {
    const Reference entry = page_entry(payload, slot);
    const std::uint64_t morton = first_morton | (static_cast<std::uint64_t>(slot) << (kPageBits * height));
    if (!entry.present()) continue;
    if (height > 0) {
      take_page(file, layer, level, entry, height - 1, morton, out);
    } else {
      out[entry.offset] = {entry.offset, entry.record_bytes(), static_cast<RecordType>(entry.kind), layer.info.id,
                           tile_from_morton(level, morton)};
    }
  }
}

Anatomy anatomy_of(const std::filesystem::path& path) {
  const Bytes file = read_file(path);
  Anatomy anatomy{.superblock = choose_superblock(std::span(file).first(kLogStart), file.size()).value().newest};
  const Reference& at = anatomy.superblock.catalog;
  anatomy.catalog = decode_catalog(std::span(file).subspan(at.offset + kRecordHeaderBytes, at.stored_bytes), anatomy.superblock.file_end,
                                   anatomy.superblock.version)
                        .value();
  std::map<std::uint64_t, Record> records;
  records[at.offset] = {at.offset, at.record_bytes(), RecordType::kCatalog};
  for (const CatalogLayer& layer : anatomy.catalog.layers)
    for (std::size_t level = 0; level < layer.roots.size(); ++level) {
      const Level l{static_cast<std::uint8_t>(level)};
      if (layer.roots[level].present()) take_page(file, layer, l, layer.roots[level], top_height(l), 0, records);
    }
  for (const auto& [offset, record] : records) anatomy.records.push_back(record);
  return anatomy;
}

// Three texture layers and a carry layer, built untidily: tiles in random order, many of them replaced, some
// removed, several commits.
//   "color"  rgb8, levels 0 to 7, dense, a third of it one of three constants
//   "height" r32f, levels 0 to 4, dense
//   "spots"  rgb8, levels 0 to 11, a few tiles with all their ancestors
void build_untidy_store(const std::filesystem::path& path, bool finished = true) {
  StoreWriter writer = value_of(StoreWriter::create(path, {.metadata_json = R"({"crs": "none"})"}, {.sync = false}));
  std::mt19937 random(11);
  const auto fill = [&](LayerId id, const LayerInfo& layer, std::vector<TileId> tiles) {
    for (const int version : {1, 0}) {
      std::shuffle(tiles.begin(), tiles.end(), random);
      for (const TileId tile : tiles) {
        if (version == 1 && random() % 2 == 0) continue;  // replaced later on, or put once
        const std::uint64_t morton = morton_code(tile.x, tile.y);
        if (layer.name == "color" && morton % 3 == 0) {
          succeed(writer.put_constant(id, tile, Bytes(3, static_cast<std::byte>(morton % 9 + static_cast<unsigned>(version)))));
        } else {
          const Compression compression = morton % 5 == 0 ? Compression{} : Compression{Codec::kZstd, 1};
          succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile, version), compression)));
        }
      }
      succeed(writer.commit());
    }
    succeed(writer.set_metadata(id, R"({"note": ")" + layer.name + R"("})"));
  };
  const auto all_tiles = [](int finest) {
    std::vector<TileId> tiles;
    for (int level = 0; level <= finest; ++level)
      for (std::uint32_t y = 0; y < 1U << level; ++y)
        for (std::uint32_t x = 0; x < 1U << level; ++x) tiles.push_back(tile_at(level, x, y));
    return tiles;
  };

  const LayerInfo color = small_layer("color", TexelFormat::kRgb8, 2, 7);
  const LayerId color_id = value_of(writer.add_layer(color));
  LayerInfo carry = small_layer("color/carry", TexelFormat::kRgba32Float, 2, 3);
  carry.role = LayerRole::kCarry;
  carry.owner = color_id;
  const LayerId carry_id = value_of(writer.add_layer(carry));
  const LayerInfo height = small_layer("height", TexelFormat::kR32Float, 3, 4);
  const LayerId height_id = value_of(writer.add_layer(height));
  const LayerInfo spots = small_layer("spots", TexelFormat::kRgb8, 2, 11);
  const LayerId spots_id = value_of(writer.add_layer(spots));
  const LayerInfo gone = small_layer("gone", TexelFormat::kRgb8, 2, 4);
  const LayerId gone_id = value_of(writer.add_layer(gone));

  fill(color_id, color, all_tiles(7));
  fill(carry_id, carry, {tile_at(3, 1, 2), tile_at(3, 7, 7)});
  fill(gone_id, gone, all_tiles(4));
  fill(height_id, height, all_tiles(4));
  std::set<TileId> sparse;
  for (const TileId spot : {tile_at(11, 0, 0), tile_at(11, 2047, 2047), tile_at(11, 1000, 77), tile_at(11, 1001, 77), tile_at(9, 300, 5)})
    for (TileId tile = spot;; tile = parent_of(tile)) {
      sparse.insert(tile);
      if (tile.level.value == 0) break;
    }
  fill(spots_id, spots, {sparse.begin(), sparse.end()});
  for (std::uint32_t x = 0; x < 128; x += 7) succeed(writer.remove(color_id, tile_at(7, x, 40)));
  succeed(writer.remove_layer(gone_id));
  for (const LayerId id : {color_id, height_id, spots_id})
    if (finished || id != height_id) succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.finish());
}

// All tiles of all layers but the carry ones; those of level 11 by their neighbourhoods, as there are four
// million.
Contents texture_contents(const StoreReader& reader) {
  Contents contents;
  for (const LayerInfo& layer : reader.layers()) {
    if (layer.role == LayerRole::kCarry) continue;
    for (int level = 0; level <= layer.finest.value; ++level) {
      const std::uint32_t side = 1U << level;
      for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
          const bool is_looked_at = level <= 7 || x < 2 || x + 2 >= side || y < 2 || y + 2 >= side ||
                                    (x >= (996U >> (11 - level)) && x <= (1004U >> (11 - level)));
          if (!is_looked_at) continue;
          const TileId tile = tile_at(level, x, y);
          if (value_of(reader.lookup(layer.id, tile)).kind == TileKind::kAbsent) continue;
          Bytes bytes(layer.tile_payload_bytes());
          succeed(reader.read(layer.id, tile, bytes));
          contents[{layer.name, tile}] = std::move(bytes);
        }
    }
  }
  return contents;
}

const PackOptions kNoSync{.writer = {.sync = false}};

struct PackTest : testing::Test {
  TempFolder folder;
  std::filesystem::path source = folder / "a.vts";
  std::filesystem::path packed = folder / "b.vts";

  PackReport pack_source(const PackOptions& options = kNoSync) {
    return value_of(pack(value_of(StoreReader::open(source)), packed, options));
  }
};

TEST_F(PackTest, KeepsEveryTileAndEveryFieldAndLeavesNothingToFind) {
  build_untidy_store(source);
  const StoreReader before = value_of(StoreReader::open(source));
  const PackReport report = pack_source();
  const StoreReader after = value_of(StoreReader::open(packed));

  EXPECT_EQ(texture_contents(before), texture_contents(after));
  EXPECT_THAT(value_of(validate(packed)).findings, IsEmpty()) << "not even garbage";
  EXPECT_NE(before.uuid(), after.uuid());
  EXPECT_EQ(before.description().metadata_json, after.description().metadata_json);
  EXPECT_EQ(before.description().area, after.description().area);
  ASSERT_EQ(after.layers().size(), 3U);
  std::uint64_t tiles = 0;
  for (const LayerInfo& layer : after.layers()) {
    const LayerInfo* original = before.find_layer(layer.name);
    EXPECT_EQ(layer.id, original->id) << "keys in records name the layer's id";
    EXPECT_EQ(layer.metadata_json, original->metadata_json);
    EXPECT_EQ(layer.tiles, original->tiles);
    EXPECT_EQ(layer.constant_tiles, original->constant_tiles);
    EXPECT_EQ(layer.stored_bytes, original->stored_bytes);
    EXPECT_EQ(layer.data, original->data);
    EXPECT_EQ(layer.state, LayerState::kComplete);
    tiles += layer.tiles;
  }
  EXPECT_EQ(report.tiles, tiles);
  EXPECT_EQ(report.source_bytes, std::filesystem::file_size(source));
  EXPECT_EQ(report.packed_bytes, std::filesystem::file_size(packed));
  EXPECT_LT(report.packed_bytes, report.source_bytes);
  EXPECT_THAT(report.dropped_layers, ElementsAre("color/carry"));
}

TEST_F(PackTest, EveryByteOfTheLogIsReachable) {
  build_untidy_store(source);
  pack_source();
  const Anatomy anatomy = anatomy_of(packed);
  std::uint64_t end = kLogStart;
  for (const Record& record : anatomy.records) {
    ASSERT_EQ(record.offset, end);
    end += record.bytes;
  }
  EXPECT_EQ(end, anatomy.superblock.file_end);
  EXPECT_EQ(end, std::filesystem::file_size(packed));
}

TEST_F(PackTest, CarryLayersComeAlongWhenAsked) {
  build_untidy_store(source);
  PackOptions options = kNoSync;
  options.keep_carry = true;
  EXPECT_THAT(pack_source(options).dropped_layers, IsEmpty());
  const StoreReader before = value_of(StoreReader::open(source));
  const StoreReader after = value_of(StoreReader::open(packed));
  ASSERT_EQ(after.layers().size(), 4U);
  const LayerInfo& carry = *after.find_layer("color/carry");
  for (const TileId tile : {tile_at(3, 1, 2), tile_at(3, 7, 7)}) {
    Bytes a(carry.tile_payload_bytes());
    Bytes b(carry.tile_payload_bytes());
    succeed(before.read(carry.id, tile, a));
    succeed(after.read(carry.id, tile, b));
    EXPECT_EQ(a, b);
  }
  EXPECT_THAT(value_of(validate(packed)).findings, testing::Each(testing::Field(&Finding::number, 501))) << "the carry layer's own state";
  // What readers of textures never ask for lies behind everything else.
  std::uint64_t last_texture = 0;
  std::uint64_t first_carry = ~std::uint64_t{0};
  for (const Record& record : anatomy_of(packed).records) {
    if (record.type == RecordType::kCatalog || record.type == RecordType::kConstant) continue;
    if (record.layer == carry.id) first_carry = std::min(first_carry, record.offset);
    if (record.layer != carry.id) last_texture = std::max(last_texture, record.offset);
  }
  EXPECT_LT(last_texture, first_carry);
}

TEST_F(PackTest, TilesLieInStreamingOrder) {
  build_untidy_store(source);
  PackOptions options = kNoSync;
  options.cold_start_bytes = 40000;
  const PackReport report = pack_source(options);
  std::map<std::uint16_t, int> cold_levels;  // by layer
  {
    const StoreReader reader = value_of(StoreReader::open(packed));
    for (const auto& layer : report.layers) cold_levels[reader.find_layer(layer.name)->id.value] = layer.cold_levels;
  }
  EXPECT_GT(report.layers[0].cold_levels, 2);
  EXPECT_LT(report.layers[0].cold_levels, 8);

  // Where a tile should lie: the cold start by level; then groups of three levels; in a group, layer by
  // layer, place by place of the group's coarsest level that is not in the cold start, level by level under
  // that place, in Morton order.
  using Key = std::tuple<int, int, int, std::uint64_t, int, std::uint64_t>;
  const auto key_of = [&](const Record& record) -> Key {
    const int level = record.tile.level.value;
    const std::uint64_t morton = morton_code(record.tile.x, record.tile.y);
    const int cold = cold_levels.at(record.layer.value);
    if (level < cold) return {0, level, record.layer.value, 0, 0, morton};
    const int first = std::max(level / 3 * 3, cold);
    return {1, level / 3, record.layer.value, morton >> (2 * (level - first)), level, morton};
  };
  std::vector<Key> order;
  for (const Record& record : anatomy_of(packed).records)
    if (record.type == RecordType::kTile) order.push_back(key_of(record));
  EXPECT_GT(order.size(), 10000U);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST_F(PackTest, AGroupsPagesLieJustBeforeItsTiles) {
  build_untidy_store(source);
  PackOptions options = kNoSync;
  options.cold_start_bytes = 1;  // nothing but the catalog: every page lies in its group
  pack_source(options);
  // Every stretch of the file that belongs to one group of one layer is pages, then tiles.
  std::set<std::pair<int, int>> seen;
  std::pair<int, int> here{-1, -1};
  bool in_tiles = false;
  for (const Record& record : anatomy_of(packed).records) {
    if (record.type == RecordType::kCatalog || record.type == RecordType::kConstant) continue;
    const std::pair<int, int> group{record.tile.level.value / 3, record.layer.value};
    if (group != here) {
      EXPECT_TRUE(seen.insert(group).second) << "one stretch a group and layer";
      EXPECT_GT(group, here) << "coarse groups first";
      here = group;
      in_tiles = false;
    }
    if (record.type == RecordType::kTile) in_tiles = true;
    EXPECT_FALSE(in_tiles && record.type == RecordType::kPage);
  }
  EXPECT_EQ(seen.size(), 3U + 2U + 4U);
}

TEST_F(PackTest, TheColdStartHoldsTheUpperIndexAndTheCoarsestLevels) {
  build_untidy_store(source);
  PackOptions options = kNoSync;
  options.cold_start_bytes = 150000;
  const PackReport report = pack_source(options);
  const Anatomy anatomy = anatomy_of(packed);
  const Extent& cold = anatomy.superblock.cold_start;
  EXPECT_EQ(cold.offset, kLogStart);
  EXPECT_EQ(cold.bytes, report.cold_start_bytes);
  EXPECT_LE(cold.bytes, options.cold_start_bytes);
  std::map<std::uint16_t, int> cold_levels;
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    ASSERT_EQ(report.layers[i].name, anatomy.catalog.layers[i].info.name);
    cold_levels[anatomy.catalog.layers[i].info.id.value] = report.layers[i].cold_levels;
    EXPECT_GE(report.layers[i].cold_levels, 3);
  }
  for (const Record& record : anatomy.records) {
    if (record.type == RecordType::kCatalog || record.type == RecordType::kConstant) continue;
    const bool is_inside = record.offset + record.bytes <= cold.offset + cold.bytes;
    const bool is_top = record.type == RecordType::kPage && record.height == top_height(record.tile.level);
    const bool is_cold_level = record.tile.level.value < cold_levels[record.layer.value];
    EXPECT_EQ(is_inside, is_top || is_cold_level);
  }
}

TEST_F(PackTest, AColdStartOutsideTheFileIsNone) {
  Superblock superblock{
      .generation = 2, .file_end = kLogStart + 128, .catalog = {.offset = kLogStart, .stored_bytes = 96, .kind = ReferenceKind::kCatalog}};
  for (const Extent wrong : {Extent{1, 5}, Extent{kLogStart, 129}, Extent{kLogStart + 192, 0}, Extent{~std::uint64_t{0}, 1},
                             Extent{kLogStart, ~std::uint64_t{0}}}) {
    superblock.cold_start = wrong;
    const auto read = decode_superblock(encode_superblock(superblock), 0);
    ASSERT_TRUE(read) << "ignorable bytes are no reason to refuse a store";
    EXPECT_EQ(read->cold_start, Extent{});
  }
  superblock.cold_start = {kLogStart + 64, 64};
  EXPECT_EQ(decode_superblock(encode_superblock(superblock), 0)->cold_start, superblock.cold_start);
}

TEST_F(PackTest, SharedRecordsStayShared) {
  build_untidy_store(source);
  pack_source();
  std::map<std::string, int> constants;
  for (const auto& path : {source, packed})
    for (const Record& record : anatomy_of(path).records) constants[path.string()] += record.type == RecordType::kConstant ? 1 : 0;
  EXPECT_EQ(constants[packed.string()], constants[source.string()]);
  EXPECT_EQ(constants[packed.string()], 3);
}

TEST_F(PackTest, PackingAPackedStoreChangesNothing) {
  build_untidy_store(source);
  pack_source();
  const Bytes once = read_file(packed);
  succeed(pack_in_place(packed, kNoSync).map([](const PackReport&) {}));
  const Bytes twice = read_file(packed);
  ASSERT_EQ(once.size(), twice.size());
  EXPECT_TRUE(std::equal(once.begin() + kLogStart, once.end(), twice.begin() + kLogStart));
}

TEST_F(PackTest, AStoreWithoutLayersIsPackedToo) {
  succeed(value_of(StoreWriter::create(source, {})).finish());
  EXPECT_EQ(pack_source().tiles, 0U);
  EXPECT_THAT(value_of(validate(packed)).findings, IsEmpty());
}

TEST_F(PackTest, RefusesAnUnfinishedLayerAndNamesIt) {
  build_untidy_store(source, false);
  const auto refused = pack(value_of(StoreReader::open(source)), packed, kNoSync);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidData);
  EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("a.vts"), HasSubstr("layer height is unfinished")));
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
}

TEST_F(PackTest, ADamagedTileIsAnErrorThatNamesItAndLeavesNothing) {
  build_untidy_store(source);
  std::uint64_t offset = 0;
  {
    const StoreReader reader = value_of(StoreReader::open(source));
    offset = value_of(reader.lookup(reader.find_layer("height")->id, tile_at(4, 9, 3))).offset;
  }
  Bytes bytes = read_file(source);
  bytes[offset + kRecordHeaderBytes + 5] ^= std::byte{1};
  write_file(source, bytes);
  for (const bool in_place : {false, true}) {
    const auto refused = in_place ? pack_in_place(source, kNoSync) : pack(value_of(StoreReader::open(source)), packed, kNoSync);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(refused.error().message, HasSubstr("layer height, level 4, tile 9,3"));
    EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
    EXPECT_EQ(read_file(source), bytes);
  }
}

TEST_F(PackTest, ATileThatDoesNotDecodeIsAnErrorThatNamesIt) {
  build_untidy_store(source);
  TileLookup lookup;
  TileId tile = tile_at(4, 0, 3);
  for (const StoreReader reader = value_of(StoreReader::open(source)); lookup.codec != Codec::kZstd; ++tile.x)
    lookup = value_of(reader.lookup(reader.find_layer("height")->id, tile));
  --tile.x;
  Bytes bytes = read_file(source);
  bytes[lookup.offset + kRecordHeaderBytes] ^= std::byte{0xFF};  // zstd's own magic
  reseal(bytes);
  write_file(source, bytes);
  const auto refused = pack(value_of(StoreReader::open(source)), packed, kNoSync);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(refused.error().message, HasSubstr("layer height, level 4, tile " + std::to_string(tile.x) + ",3: "));
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
}

TEST_F(PackTest, ATileWithoutItsParentIsAnErrorThatNamesIt) {
  for (const TileId orphan : {tile_at(1, 1, 0), tile_at(4, 15, 15), tile_at(7, 100, 3)}) {
    std::filesystem::remove(source);
    build_untidy_store(source);
    StoreWriter writer = value_of(StoreWriter::open(source, {.sync = false}));
    const LayerId color = writer.find_layer("color")->id;
    succeed(writer.remove(color, parent_of(orphan)));
    succeed(writer.finish());
    const auto refused = pack(value_of(StoreReader::open(source)), packed, kNoSync);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(refused.error().message,
                testing::AllOf(HasSubstr("layer color, level " + std::to_string(orphan.level.value)), HasSubstr("its parent is absent")));
  }
}

// Whatever was changed under right checksums, a packed store is a valid one.
TEST_F(PackTest, ForgedStoresAreRefusedOrPackedIntoValidOnes) {
  {
    StoreWriter writer = value_of(StoreWriter::create(source, {}, {.sync = false}));
    const LayerInfo color = small_layer("color", TexelFormat::kRgb8, 2, 6);
    const LayerInfo height = small_layer("height", TexelFormat::kR32Float, 3, 2);
    const LayerId color_id = value_of(writer.add_layer(color));
    const LayerId height_id = value_of(writer.add_layer(height));
    LayerInfo notes = small_layer("notes", TexelFormat::kBlob, 2, 1);
    notes.role = LayerRole::kCarry;
    notes.owner = color_id;
    const LayerId notes_id = value_of(writer.add_layer(notes));
    for (int level = 0; level <= 6; ++level)
      succeed(level % 3 == 1 ? writer.put_constant(color_id, tile_at(level, 0, 0), Bytes(3, std::byte{7}))
                             : writer.put(color_id, tile_at(level, 0, 0), encoded(tile_bytes(color, tile_at(level, 0, 0)))));
    succeed(writer.put(color_id, tile_at(2, 1, 0), encoded(tile_bytes(color, tile_at(2, 0, 0)))));  // shared
    for (int level = 0; level <= 2; ++level)
      succeed(
          writer.put(height_id, tile_at(level, 0, 0), encoded(height, smooth_tile_bytes(height, tile_at(level, 0, 0)), {Codec::kZstd, 3})));
    succeed(writer.put(notes_id, tile_at(1, 0, 1), encoded(Bytes(100, std::byte{9}), {Codec::kZstd, 1})));
    for (const LayerId id : {color_id, height_id}) succeed(writer.set_state(id, LayerState::kComplete));
    succeed(writer.finish());
  }
  const Bytes good = read_file(source);
  PackOptions options = kNoSync;
  options.keep_carry = true;
  int valid = 0;
  int refused = 0;
  const auto attack = [&](Bytes changed) {
    reseal(changed);
    write_file(source, changed);
    const auto reader = StoreReader::open(source);
    if (!reader) return;
    const bool was_valid = value_of(validate(source)).ok();
    const auto report = pack(*reader, packed, options);
    if (report) {
      const auto after = value_of(validate(packed));
      for (const Finding& finding : after.findings) EXPECT_FALSE(finding.is_error) << finding.number << " " << finding.sentence;
      std::filesystem::remove(packed);
      ++valid;
    } else {
      EXPECT_TRUE(!was_valid || report.error().code == ErrorCode::kInvalidData) << report.error().message;  // or a layer that is unfinished
      ++refused;
    }
  };
  // A few texels, which may be any, stand for all.
  for (std::uint64_t record = kLogStart; record + kRecordHeaderBytes <= good.size();) {
    if (get<std::uint32_t>(good, record + 8) != 0x43525456) {
      record += kRecordAlignment;
      continue;
    }
    const auto type = static_cast<RecordType>(get<std::uint8_t>(good, record + 12));
    const std::uint64_t end = record + kRecordHeaderBytes + get<std::uint32_t>(good, record + 20);
    const std::size_t step = type == RecordType::kCatalog || type == RecordType::kPage ? 2 : 29;
    for (std::uint64_t at = record + 8; at < end; at += at < record + kRecordHeaderBytes + 4 ? 1 : step) {
      Bytes changed = good;
      changed[at] = at % 3 == 0 ? std::byte{0xFF} : good[at] ^ std::byte{0x01};
      if (changed[at] != good[at]) attack(std::move(changed));
      if (HasFailure()) FAIL() << "byte " << at;
    }
    record += aligned(end - record);
  }
  EXPECT_GT(valid, 300);
  EXPECT_GT(refused, 100);
}

TEST_F(PackTest, ADamagedPageIsAnErrorThatSaysWhere) {
  build_untidy_store(source);
  const Anatomy anatomy = anatomy_of(source);
  const auto page = std::find_if(anatomy.records.begin(), anatomy.records.end(), [](const Record& record) {
    return record.type == RecordType::kPage && record.tile == tile_at(7, 32, 0) && record.height == 0;
  });
  ASSERT_NE(page, anatomy.records.end());
  Bytes bytes = read_file(source);
  bytes[page->offset + kRecordHeaderBytes + 300] ^= std::byte{1};
  write_file(source, bytes);
  const auto refused = pack(value_of(StoreReader::open(source)), packed, kNoSync);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("layer color, level 7, tile 32,0"), HasSubstr("index page")));
}

TEST_F(PackTest, NeverReplacesAFileUnlessThatIsTheWish) {
  build_untidy_store(source);
  write_file(packed, Bytes(5));
  const auto refused = pack(value_of(StoreReader::open(source)), packed, kNoSync);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kExists);
  EXPECT_EQ(read_file(packed), Bytes(5));
}

TEST_F(PackTest, InPlaceTheStoreGoesOnUnderItsOwnName) {
  build_untidy_store(source);
  std::filesystem::permissions(source, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const std::filesystem::path link = folder / "link.vts";
  std::filesystem::create_symlink("a.vts", link);
  const StoreReader before = value_of(StoreReader::open(source));
  const Contents truth = texture_contents(before);

  const PackReport report = value_of(pack_in_place(link, {}));
  EXPECT_LT(report.packed_bytes, report.source_bytes);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts", "link.vts"));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(std::filesystem::status(source).permissions(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  EXPECT_EQ(texture_contents(before), truth) << "who had it open keeps the old file";
  {
    const StoreReader after = value_of(StoreReader::open(source));
    EXPECT_EQ(texture_contents(after), truth);
    EXPECT_EQ(after.uuid(), before.uuid());
    EXPECT_GT(after.generation(), before.generation());
  }

  // And it can be written to again; the hint about its front stays.
  StoreWriter writer = value_of(StoreWriter::open(source, {.sync = false}));
  const LayerInfo layer = *writer.find_layer("height");
  succeed(writer.put(layer.id, tile_at(2, 1, 1), encoded(tile_bytes(layer, tile_at(2, 1, 1), 9))));
  succeed(writer.finish());
  Bytes out(layer.tile_payload_bytes());
  succeed(value_of(StoreReader::open(source)).read(layer.id, tile_at(2, 1, 1), out));
  EXPECT_EQ(out, tile_bytes(layer, tile_at(2, 1, 1), 9));
  EXPECT_TRUE(value_of(validate(source)).ok());
  EXPECT_EQ(anatomy_of(source).superblock.cold_start.bytes, report.cold_start_bytes);
}

TEST_F(PackTest, InPlaceRefusesWhileAWriterHasTheStore) {
  build_untidy_store(source);
  const Bytes before = read_file(source);
  StoreWriter writer = value_of(StoreWriter::open(source));
  const auto refused = pack_in_place(source, kNoSync);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kExists);
  EXPECT_THAT(refused.error().message, HasSubstr("another program is writing"));
  EXPECT_EQ(read_file(source), before);
}

TEST_F(PackTest, StopsWhenAsked) {
  build_untidy_store(source);
  std::atomic<bool> cancel = false;
  PackOptions options = kNoSync;
  options.cancel = &cancel;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_LE(done, total);
    if (done > 3000) cancel = true;
  };
  const auto stopped = pack(value_of(StoreReader::open(source)), packed, options);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts"));
}

TEST_F(PackTest, AFullDiskAtAnyWriteLeavesTheOriginalAndNothingElse) {
  StoreWriter writer = value_of(StoreWriter::create(source, {}, {.sync = false}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 2, 3);
  const LayerId id = value_of(writer.add_layer(layer));
  for (std::uint32_t y = 0; y < 8; ++y)
    for (std::uint32_t x = 0; x < 8; ++x) succeed(writer.put(id, tile_at(3, x, y), encoded(tile_bytes(layer, tile_at(3, x, y)))));
  for (int level = 0; level < 3; ++level)
    for (std::uint32_t i = 0; i < 1U << (2 * level); ++i)
      succeed(writer.put_constant(id, tile_from_morton(Level{static_cast<std::uint8_t>(level)}, i), Bytes(3)));
  succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.finish());
  const Bytes before = read_file(source);
  for (const bool in_place : {false, true}) {
    std::size_t refuse_at = 0;
    for (;; ++refuse_at) {
      std::size_t count = 0;
      PackOptions options;
      options.writer.before_operation = [&](const FileOperation&) { return count++ == refuse_at ? ENOSPC : 0; };
      const auto outcome = in_place ? pack_in_place(source, options) : pack(value_of(StoreReader::open(source)), packed, options);
      if (outcome) break;
      EXPECT_EQ(outcome.error().code, ErrorCode::kIo);
      EXPECT_THAT(outcome.error().message, HasSubstr("No space left on device"));
      ASSERT_EQ(read_file(source), before);
      ASSERT_EQ(names_in(folder.path()), in_place ? std::vector<std::string>({"a.vts", "b.vts"}) : std::vector<std::string>({"a.vts"}));
    }
    EXPECT_GT(refuse_at, 6U);
  }
  EXPECT_EQ(read_all(value_of(StoreReader::open(source))), read_all(value_of(StoreReader::open(packed))));
}

// The child ends itself at one of its writes after the other, so every moment is met, however busy the
// machine is.
TEST_F(PackTest, AKilledPackLeavesAWholeStoreAndNoPartialTarget) {
  build_untidy_store(source);
  const Contents truth = texture_contents(value_of(StoreReader::open(source)));
  for (const bool in_place : {true, false}) {
    std::size_t killed = 0;
    for (bool is_whole = false; !is_whole; ++killed) {
      const pid_t child = fork();
      ASSERT_GE(child, 0);
      if (child == 0) {
        std::size_t count = 0;
        PackOptions options = kNoSync;
        // The many pages are written one by one: a few of them stand for all.
        options.writer.before_operation = [&](const FileOperation&) {
          if (count++ == killed * killed / 2) kill(getpid(), SIGKILL);
          return 0;
        };
        if (in_place) _exit(pack_in_place(source, options) ? 0 : 3);
        auto reader = StoreReader::open(source);
        _exit(reader && pack(*reader, packed, options) ? 0 : 3);
      }
      int status = 0;
      ASSERT_EQ(waitpid(child, &status, 0), child);
      is_whole = WIFEXITED(status);
      ASSERT_TRUE(!is_whole || WEXITSTATUS(status) == 0) << "the child failed by itself";
      ASSERT_TRUE(value_of(validate(source)).ok());
      ASSERT_EQ(std::filesystem::exists(packed), is_whole && !in_place);
    }
    EXPECT_GT(killed, 6U);
  }
  ASSERT_TRUE(value_of(validate(packed)).ok());
  EXPECT_EQ(texture_contents(value_of(StoreReader::open(source))), truth);
  EXPECT_EQ(texture_contents(value_of(StoreReader::open(packed))), truth);
  // What a killed process cannot clear away has a name of its own, and goes with the next pack.
  EXPECT_THAT(names_in(folder.path()), ElementsAre("a.vts", "b.vts"));
}

}  // namespace
}  // namespace vt::store
