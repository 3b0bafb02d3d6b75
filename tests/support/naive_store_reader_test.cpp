// Two readers of one format, StoreReader and the naive one, must agree: on every field, on every tile, and on
// what is damaged.
#include "tests/support/naive_store_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>
#include <set>
#include <stdexcept>

#include "store/store_reader.h"
#include "store/store_writer.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"
#include "tests/support/format_lists.h"

namespace vt::test {
namespace {

using store::Codec;
using store::StoreReader;
using store::StoreWriter;
using store::test::Bytes;
using store::test::encoded;
using store::test::read_file;
using store::test::small_layer;
using store::test::smooth_tile_bytes;
using store::test::succeed;
using store::test::TempFolder;
using store::test::tile_bytes;
using store::test::value_of;

TileId tile_at(int level, std::uint32_t x, std::uint32_t y) { return {Level{static_cast<std::uint8_t>(level)}, x, y}; }

// What a reader says about a tile: bytes, "absent" or "damaged".
struct Answer {
  std::string word;
  Bytes bytes;
  bool operator==(const Answer&) const = default;
};

Answer answer_of(const StoreReader& reader, const LayerInfo& layer, TileId tile) {
  Bytes bytes(layer.tile_payload_bytes());
  const auto read = layer.holds_blobs() ? reader.read_blob(layer.id, tile, bytes) : reader.read(layer.id, tile, bytes);
  if (read) return {"bytes", bytes};
  return {read.error().code == ErrorCode::kNotFound ? "absent" : "damaged", {}};
}

Answer answer_of(const NaiveStoreReader& naive, unsigned layer, TileId tile) {
  try {
    const auto bytes = naive.tile(layer, tile.level.value, tile.x, tile.y);
    return bytes ? Answer{"bytes", *bytes} : Answer{"absent", {}};
  } catch (const std::runtime_error&) {
    return {"damaged", {}};
  }
}

std::optional<NaiveStoreReader> open_naive(const Bytes& file) {
  try {
    return NaiveStoreReader(file);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

std::string text_of(const NaiveBytes& uuid) {
  std::string text;
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", std::to_integer<unsigned>(uuid[i]));
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += two;
  }
  return text;
}

// Section 2: JSON texts may be empty, which means {}.
std::string json_of(const std::string& text) { return text.empty() ? "{}" : text; }

// Doubles by their bits: a NaN agrees with itself.
void expect_same_bits(double a, double b, const std::string& what) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)) << what;
}

void expect_same_layer(const LayerInfo& layer, const NaiveLayer& naive) {
  EXPECT_EQ(layer.id.value, naive.id);
  EXPECT_EQ(layer.name, naive.name);
  EXPECT_EQ(static_cast<unsigned>(layer.channel), naive.channel);
  EXPECT_EQ(static_cast<unsigned>(layer.format), naive.format);
  EXPECT_EQ(static_cast<unsigned>(layer.transfer), naive.transfer);
  EXPECT_EQ(static_cast<unsigned>(layer.role), naive.role);
  EXPECT_EQ(static_cast<unsigned>(layer.state), naive.state);
  EXPECT_EQ(layer.owner.value, naive.owner);
  EXPECT_EQ(layer.tile_exponent, naive.tile_exponent);
  EXPECT_EQ(layer.finest.value, naive.finest);
  EXPECT_EQ(layer.data, (TexelRect{naive.data_x, naive.data_y, naive.data_width, naive.data_height}));
  expect_same_bits(layer.grid.origin_x, naive.origin_x, "origin_x");
  expect_same_bits(layer.grid.origin_y, naive.origin_y, "origin_y");
  expect_same_bits(layer.grid.step_x, naive.step_x, "step_x");
  expect_same_bits(layer.grid.step_y, naive.step_y, "step_y");
  expect_same_bits(layer.source_nodata, naive.source_nodata, "source_nodata");
  EXPECT_EQ(json_of(layer.metadata_json), json_of(naive.metadata_json));
  EXPECT_EQ(layer.is_part, naive.is_part);
  EXPECT_EQ(layer.zero_is_nodata, naive.zero_is_nodata);
  EXPECT_EQ(layer.is_point_sampled, naive.is_point_sampled);
  for (std::size_t c = 0; c < 4; ++c) EXPECT_EQ(layer.components[c], (ComponentRange{.scale = naive.scale[c], .offset = naive.offset[c]}));
  EXPECT_EQ(layer.tiles, naive.tiles);
  EXPECT_EQ(layer.constant_tiles, naive.constant_tiles);
  EXPECT_EQ(layer.stored_bytes, naive.stored_bytes);
}

void expect_same_catalog(const StoreReader& reader, const NaiveStoreReader& naive) {
  EXPECT_EQ(reader.generation(), naive.generation());
  EXPECT_EQ(reader.uuid(), text_of(naive.uuid()));
  const NaiveCatalog& catalog = naive.catalog();
  EXPECT_EQ(reader.description().area, (Area{.west = catalog.west, .south = catalog.south, .east = catalog.east, .north = catalog.north}));
  EXPECT_EQ(json_of(reader.description().metadata_json), json_of(catalog.metadata_json));
  ASSERT_EQ(reader.layers().size(), catalog.layers.size());
  for (std::size_t i = 0; i < catalog.layers.size(); ++i) expect_same_layer(reader.layers()[i], catalog.layers[i]);
}

// All tiles of the coarse levels; of the deeper ones those named, their neighbours and some at random.
std::set<TileId> tiles_to_ask(const LayerInfo& layer, const std::set<TileId>& named) {
  std::set<TileId> tiles;
  std::mt19937 random(layer.id.value);
  for (int level = 0; level <= layer.finest.value; ++level) {
    const std::uint32_t side = 1U << level;
    if (level <= 4) {
      for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) tiles.insert(tile_at(level, x, y));
    }
    for (int i = 0; i < 20; ++i) tiles.insert(tile_at(level, random() % side, random() % side));
  }
  for (const TileId& tile : named) {
    for (TileId at = tile;; at = parent_of(at)) {
      if (at.level <= layer.finest) {
        const std::uint32_t last = (1U << at.level.value) - 1;
        for (const std::uint32_t x : {at.x, at.x ^ 1U, std::min(at.x + 1, last)})
          for (const std::uint32_t y : {at.y, at.y ^ 1U, std::min(at.y + 1, last)})
            if (x <= last && y <= last) tiles.insert(tile_at(at.level.value, x, y));
      }
      if (at.level.value == 0) break;
    }
  }
  return tiles;
}

// How many of the tiles were there.
std::uint64_t expect_same_tiles(const StoreReader& reader, const NaiveStoreReader& naive, const std::set<TileId>& named = {}) {
  std::uint64_t present = 0;
  for (const LayerInfo& layer : reader.layers()) {
    for (const TileId& tile : tiles_to_ask(layer, named)) {
      const Answer ours = answer_of(reader, layer, tile);
      const Answer theirs = answer_of(naive, layer.id.value, tile);
      EXPECT_EQ(ours.word, theirs.word) << layer.name << " level " << int{tile.level.value} << " x " << tile.x << " y " << tile.y;
      EXPECT_TRUE(ours.bytes == theirs.bytes) << layer.name << " level " << int{tile.level.value} << " x " << tile.x << " y " << tile.y;
      if (ours.word == "bytes") ++present;
    }
  }
  return present;
}

std::uint64_t expect_agreement(const std::filesystem::path& path, const std::set<TileId>& named = {}) {
  const StoreReader reader = value_of(StoreReader::open(path));
  const NaiveStoreReader naive = NaiveStoreReader::open(path);
  expect_same_catalog(reader, naive);
  return expect_same_tiles(reader, naive, named);
}

std::uint64_t tiles_in(const std::filesystem::path& path) {
  const NaiveStoreReader naive = NaiveStoreReader::open(path);
  std::uint64_t tiles = 0;
  for (const NaiveLayer& layer : naive.catalog().layers) tiles += layer.tiles;
  return tiles;
}

// All but blobs.
void put(StoreWriter& writer, const LayerInfo& layer, LayerId id, TileId tile, int version, Codec codec) {
  succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile, version), {codec, 3})));
}

void put_smooth(StoreWriter& writer, const LayerInfo& layer, LayerId id, TileId tile) {
  succeed(writer.put(id, tile, encoded(layer, smooth_tile_bytes(layer, tile), {Codec::kZstd, 3})));
}

void put_constant(StoreWriter& writer, const LayerInfo& layer, LayerId id, TileId tile, int value) {
  Bytes block(format_info(layer.format).block_bytes);
  for (std::size_t i = 0; i < block.size(); ++i) block[i] = static_cast<std::byte>(value + static_cast<int>(i));
  succeed(writer.put_constant(id, tile, block));
}

TEST(NaiveStoreReader, AgreesOnAStoreWithoutLayers) {
  const TempFolder folder;
  value_of(StoreWriter::create(folder / "a.vts", {}));
  EXPECT_EQ(expect_agreement(folder / "a.vts"), 0U);
  EXPECT_EQ(NaiveStoreReader::open(folder / "a.vts").generation(), 1U);
}

TEST(NaiveStoreReader, AgreesOnEveryFormatAndEveryField) {
  const TempFolder folder;
  StoreWriter writer =
      value_of(StoreWriter::create(folder / "a.vts", {.area = {.west = 179.5, .south = -18.25, .east = 180.5, .north = -17.0},
                                                      .metadata_json = R"({"crs":"EPSG:4326"})"}));
  int number = 0;
  for (const TexelFormat format : texture_formats()) {
    LayerInfo layer = small_layer("layer " + std::to_string(number), format, 2 + number % 7, 3);
    layer.channel = static_cast<ChannelType>(1 + number % 8);
    layer.transfer = number == 0 ? Transfer::kSrgb : Transfer::kLinear;
    layer.data = {.x = 1, .y = 2 + number, .width = 5 + number, .height = 7};
    layer.grid = {.origin_x = 179.5 + number, .origin_y = -17.0, .step_x = 0.125, .step_y = 0.25};
    layer.source_nodata = number % 2 == 0 ? -9999.0 : std::nan("");
    layer.components[static_cast<std::size_t>(number) % 4] = {.scale = 0.5 + number, .offset = -number / 3.0};
    layer.is_part = number % 5 == 4;
    if (layer.is_part) layer.owner = {0};
    layer.zero_is_nodata = format_info(format).samples == SampleKind::kUnorm16;
    layer.is_point_sampled = format == TexelFormat::kR32Float;
    layer.metadata_json = R"({"number":)" + std::to_string(number) + "}";
    const LayerId id = value_of(writer.add_layer(layer));
    for (std::uint32_t i = 0; i < 8; ++i) {
      put(writer, layer, id, tile_at(3, i, (i * 5) % 8), 0, i % 2 == 0 ? Codec::kRaw : Codec::kZstd);
      put_constant(writer, layer, id, tile_at(3, i, (i * 5 + 1) % 8), static_cast<int>(i % 2));
    }
    put(writer, layer, id, tile_at(0, 0, 0), 0, Codec::kZstd);
    put(writer, layer, id, tile_at(1, 1, 0), 0, Codec::kRaw);
    for (std::uint32_t x = 0; x < 4; ++x) put_smooth(writer, layer, id, tile_at(2, x, 1));
    if (number % 2 == 0) succeed(writer.set_state(id, LayerState::kComplete));
    ++number;
  }
  LayerInfo carry = small_layer("carry", TexelFormat::kRgba32Float, 2, 1);
  carry.role = LayerRole::kCarry;
  carry.owner = {1};
  put(writer, carry, value_of(writer.add_layer(carry)), tile_at(1, 0, 1), 0, Codec::kRaw);
  LayerInfo blobs = small_layer("blobs", TexelFormat::kBlob, 2, 1);
  blobs.role = LayerRole::kCarry;
  blobs.owner = {3};
  const LayerId blobs_id = value_of(writer.add_layer(blobs));
  for (const std::uint32_t x : {0U, 1U})
    succeed(writer.put(blobs_id, tile_at(1, x, 1), encoded(Bytes(777, std::byte{9}), {x == 0 ? Codec::kRaw : Codec::kZstd, 3})));
  succeed(writer.finish());

  const auto formats = static_cast<unsigned>(texture_formats().size());
  EXPECT_EQ(expect_agreement(folder / "a.vts"), formats * 22 + 3);
  EXPECT_EQ(tiles_in(folder / "a.vts"), formats * 22 + 3);
}

// Sets the flag of the first layer in the catalogs of both superblocks.
void set_zero_is_nodata(Bytes& file) {
  for (const std::uint64_t slot : {0U, 4096U}) {
    const std::uint64_t catalog = store::get_reference(file, slot + 48).offset;
    const std::uint64_t layers = catalog + 32;
    if (catalog == 0 || store::get<std::uint32_t>(file, layers) == 0) continue;
    file[layers + 48 + 14] |= std::byte{2};
  }
  store::test::reseal(file);
}

// Which formats have codes is written in both readers. In a file that no writer makes every
// format gets the same verdict from both.
TEST(NaiveStoreReader, AgreesOnWhichFormatsMayHaveZeroAsNoData) {
  std::set<bool> verdicts;
  for (const TexelFormat format : texture_formats()) {
    const TempFolder folder;
    StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
    LayerInfo layer = small_layer("layer", format, 3, 1);
    const LayerId id = value_of(writer.add_layer(layer));
    put(writer, layer, id, tile_at(1, 1, 1), 0, Codec::kRaw);
    succeed(writer.finish());
    Bytes file = read_file(folder / "a.vts");
    set_zero_is_nodata(file);
    store::test::write_file(folder / "b.vts", file);
    ASSERT_TRUE(StoreReader::open(folder / "a.vts"));
    const bool is_allowed = StoreReader::open(folder / "b.vts").has_value();
    EXPECT_EQ(open_naive(file).has_value(), is_allowed) << format_name(format);
    verdicts.insert(is_allowed);
  }
  EXPECT_EQ(verdicts.size(), 2U) << "the flag was not set, or spoiled every store";
}

TEST(NaiveStoreReader, AgreesOnFarApartTilesOfDeepLevels) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  std::set<TileId> named;
  std::uint64_t tiles = 0;
  // Levels where the top page changes height: 5 and 6, 10 and 11, 15 and 16, 20 and 21.
  for (const int finest : {5, 6, 10, 11, 12, 15, 16, 20, 21, 23}) {
    const LayerInfo layer = small_layer("finest " + std::to_string(finest), TexelFormat::kRgb8, 2, finest);
    const LayerId id = value_of(writer.add_layer(layer));
    for (const int level : {finest / 2, finest}) {
      const std::uint32_t last = (1U << level) - 1;
      for (const TileId tile :
           std::set<TileId>{tile_at(level, 0, 0), tile_at(level, last, 0), tile_at(level, 0, last), tile_at(level, last, last),
                            tile_at(level, last / 2, last / 3), tile_at(level, last / 2 + 1, last / 3)}) {
        put(writer, layer, id, tile, finest, tile.x % 2 == 0 ? Codec::kZstd : Codec::kRaw);
        named.insert(tile);
        ++tiles;
      }
    }
  }
  succeed(writer.finish());
  EXPECT_EQ(expect_agreement(folder / "a.vts", named), tiles);
  EXPECT_EQ(tiles_in(folder / "a.vts"), tiles);
}

// A golden store; the layer of the unknown format counts for three tiles, none of which either reader gives.
TEST(NaiveStoreReader, AgreesOnNumbersThatNeitherKnows) {
  const auto path = std::filesystem::path(VT_SOURCE_DIR) / "tests/golden/unknown-numbers.vts";
  EXPECT_EQ(expect_agreement(path), tiles_in(path) - 3);
}

TEST(NaiveStoreReader, AgreesOnFullPages) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("full", TexelFormat::kRgb8, 2, 6);
  const LayerId id = value_of(writer.add_layer(layer));
  std::set<TileId> named;
  for (std::uint32_t y = 0; y < 64; ++y) {
    for (std::uint32_t x = 0; x < 64; ++x) {
      const TileId tile = tile_at(6, x, y);
      named.insert(tile);
      if ((x + y) % 3 == 0) {
        put_constant(writer, layer, id, tile, static_cast<int>(x));
      } else {
        put(writer, layer, id, tile, 0, Codec::kRaw);
      }
    }
  }
  succeed(writer.finish());
  EXPECT_EQ(expect_agreement(folder / "a.vts", named), 4096U);
}

TEST(NaiveStoreReader, AgreesOnEveryGenerationOfAStoreThatIsAppendedTo) {
  const TempFolder folder;
  const auto path = folder / "a.vts";
  value_of(StoreWriter::create(path, {}));
  std::mt19937 random(7);
  std::set<TileId> named;
  const LayerInfo color = small_layer("color", TexelFormat::kRgba8, 3, 12);
  const LayerInfo height = small_layer("height", TexelFormat::kR32Float, 2, 4);
  for (int version = 0; version < 12; ++version) {
    StoreWriter writer = value_of(StoreWriter::open(path));
    if (version == 0) value_of(writer.add_layer(color));
    if (version == 2 || version == 9) value_of(writer.add_layer(height));
    if (version == 7) succeed(writer.remove_layer(writer.find_layer("height")->id));
    // Two commits a turn, the second seen while the writer is still there.
    for (int turn = 0; turn < 2; ++turn) {
      for (const LayerInfo& layer : writer.layers()) {
        for (int i = 0; i < 30; ++i) {
          const int level = static_cast<int>(random() % (layer.finest.value + 1U));
          const TileId tile = tile_at(level, random() % (1U << level), random() % (1U << level));
          named.insert(tile);
          if (i % 5 == 0) {
            put_constant(writer, layer, layer.id, tile, static_cast<int>(random() % 3));
          } else {
            put(writer, layer, layer.id, tile, version, i % 2 == 0 ? Codec::kZstd : Codec::kRaw);
          }
        }
        for (const TileId& tile : named) {
          if (random() % 4 == 0 && tile.level <= layer.finest && writer.contains(layer.id, tile)) succeed(writer.remove(layer.id, tile));
        }
      }
      succeed(writer.commit());
      expect_agreement(path, named);
    }
    // What is never committed is not there.
    put(writer, color, writer.find_layer("color")->id, tile_at(0, 0, 0), 100 + version, Codec::kRaw);
    expect_agreement(path, named);
  }
  EXPECT_EQ(NaiveStoreReader::open(path).generation(), 1U + 2 * 24);
}

TEST(NaiveStoreReader, AgreesOnALayerEmptiedOfItsTiles) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 12);
  const LayerId id = value_of(writer.add_layer(layer));
  const std::set<TileId> named = {tile_at(12, 0, 0), tile_at(12, 4095, 4095), tile_at(0, 0, 0)};
  for (const TileId& tile : named) put(writer, layer, id, tile, 0, Codec::kRaw);
  succeed(writer.commit());
  EXPECT_EQ(expect_agreement(folder / "a.vts", named), 3U);
  for (const TileId& tile : named) succeed(writer.remove(id, tile));
  succeed(writer.finish());
  EXPECT_EQ(expect_agreement(folder / "a.vts", named), 0U);
  EXPECT_EQ(tiles_in(folder / "a.vts"), 0U);
}

TEST(NaiveStoreReader, AgreesThatNothingLiesOutsideALevel) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 1);
  const LayerId id = value_of(writer.add_layer(layer));
  put_constant(writer, layer, id, tile_at(1, 0, 0), 1);
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  const NaiveStoreReader naive = NaiveStoreReader::open(folder / "a.vts");
  for (const TileId tile :
       {tile_at(1, 2, 0), tile_at(1, 0, 2), tile_at(1, 0xFFFFFFFF, 0), tile_at(0, 1, 1), tile_at(2, 0, 0), tile_at(255, 0, 0)}) {
    EXPECT_EQ(answer_of(reader, reader.layers()[0], tile).word, "absent");
    EXPECT_EQ(answer_of(naive, id.value, tile).word, "absent");
  }
  EXPECT_EQ(answer_of(naive, id.value, tile_at(1, 0, 0)).word, "bytes");
}

TEST(NaiveStoreReader, ReadsTheGoodGoldens) {
  const std::filesystem::path goldens = std::filesystem::path(VT_SOURCE_DIR) / "tests/golden";
  for (const char* name : {"smallest.vts", "rich.vts", "predicted.vts", "shared.vts", "version-1-smallest.vts", "version-1-rich.vts"}) {
    std::set<TileId> named;
    for (int level = 0; level <= 6; ++level) named.insert(tile_at(level, (1U << level) - 1, 0));
    EXPECT_EQ(expect_agreement(goldens / name, named), tiles_in(goldens / name)) << name;
  }
}

// ---- Damage ----

// Overwrites a file of the same size in place: many file systems wait for the disk when a file is cut to
// nothing first.
void overwrite(const std::filesystem::path& path, const Bytes& file) {
  std::fstream stream(path, std::ios::binary | std::ios::in | std::ios::out);
  stream.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
  if (!stream.flush()) throw std::runtime_error(path.string() + ": cannot write");
}

// Opens both readers on `file`, which also lies at `path`, and compares what they say of the tiles. Says
// where they differ, or nothing.
std::string difference(const std::filesystem::path& path, const Bytes& file, const std::vector<std::pair<LayerId, TileId>>& tiles) {
  const auto reader = StoreReader::open(path);
  const auto naive = open_naive(file);
  if (reader.has_value() != naive.has_value())
    return reader ? "only StoreReader opens it" : "only the naive reader opens it: " + reader.error().message;
  if (!reader) return "";
  expect_same_catalog(*reader, *naive);
  for (const auto& [id, tile] : tiles) {
    const LayerInfo* layer = reader->find_layer(id);
    if (layer == nullptr || tile.level > layer->finest) continue;
    const Answer ours = answer_of(*reader, *layer, tile);
    const Answer theirs = answer_of(*naive, id.value, tile);
    if (ours == theirs) continue;
    return "layer " + std::to_string(id.value) + " level " + std::to_string(tile.level.value) + " x " + std::to_string(tile.x) +
           ": StoreReader says " + ours.word + ", the naive reader " + theirs.word;
  }
  return "";
}

// Every structure in little space: two layers, a carry layer, raw, zstd and constant tiles, pages of height 0
// and 1, an older generation.
class DamagedStore : public testing::Test {
 protected:
  void SetUp() override {
    StoreWriter writer = value_of(StoreWriter::create(path_, {.area = {}, .metadata_json = "{}"}));
    const LayerInfo color = small_layer("color", TexelFormat::kRgb8, 2, 6);
    const LayerId color_id = value_of(writer.add_layer(color));
    put(writer, color, color_id, tile_at(0, 0, 0), 0, Codec::kZstd);
    succeed(writer.commit());
    LayerInfo carry = small_layer("c\xC3\xA4rry", TexelFormat::kRgba32Float, 2, 0);
    carry.role = LayerRole::kCarry;
    carry.owner = color_id;
    carry.metadata_json = "{}";
    const LayerId carry_id = value_of(writer.add_layer(carry));
    put(writer, color, color_id, tile_at(6, 63, 0), 0, Codec::kRaw);
    put_constant(writer, color, color_id, tile_at(6, 0, 63), 5);
    put(writer, carry, carry_id, tile_at(0, 0, 0), 0, Codec::kRaw);
    LayerInfo height = small_layer("height", TexelFormat::kR32Float, 3, 0);
    const LayerId height_id = value_of(writer.add_layer(height));
    put_smooth(writer, height, height_id, tile_at(0, 0, 0));
    succeed(writer.finish());
    file_ = read_file(path_);
    const StoreReader reader = value_of(StoreReader::open(path_));
    ASSERT_EQ(value_of(reader.lookup(color_id, tile_at(0, 0, 0))).codec, Codec::kZstd);
    ASSERT_EQ(value_of(reader.lookup(height_id, tile_at(0, 0, 0))).codec, Codec::kPredictedZstd);
    tiles_ = {{color_id, tile_at(0, 0, 0)},  {color_id, tile_at(3, 1, 1)},   {color_id, tile_at(6, 63, 0)}, {color_id, tile_at(6, 62, 0)},
              {color_id, tile_at(6, 0, 63)}, {color_id, tile_at(6, 63, 63)}, {carry_id, tile_at(0, 0, 0)},  {height_id, tile_at(0, 0, 0)}};
  }

  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "a.vts";
  Bytes file_;
  std::vector<std::pair<LayerId, TileId>> tiles_;
};

TEST_F(DamagedStore, EveryPrefixGetsTheSameVerdict) {
  for (std::size_t size = file_.size(); size-- > 0;) {
    std::filesystem::resize_file(path_, size);
    const Bytes cut(file_.begin(), file_.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_EQ(difference(path_, cut, tiles_), "") << "cut at " << size;
  }
}

TEST_F(DamagedStore, EveryByteFlipGetsTheSameVerdict) {
  for (std::size_t at = 0; at < file_.size(); ++at) {
    Bytes damaged = file_;
    damaged[at] ^= static_cast<std::byte>(1U << (at % 8));
    overwrite(path_, damaged);
    ASSERT_EQ(difference(path_, damaged, tiles_), "") << "byte " << at;
  }
}

// Checksums renewed after the damage, so that both readers come to the checks behind them.
TEST_F(DamagedStore, EveryByteFlipUnderRightChecksumsGetsTheSameVerdict) {
  for (std::size_t at = 0; at < file_.size(); ++at) {
    // One byte in 61 of the superblocks' long reserved parts will do.
    if (at < 8192 && at % 4096 > 200 && at % 61 != 0) continue;
    for (const unsigned flip : {0x01U, 0x02U, 0x04U, 0x10U, 0x80U, 0xFFU}) {
      Bytes damaged = file_;
      damaged[at] ^= static_cast<std::byte>(flip);
      store::test::reseal(damaged);
      overwrite(path_, damaged);
      EXPECT_EQ(difference(path_, damaged, tiles_), "") << "byte " << at << " xor " << flip;
    }
  }
}

TEST(NaiveStoreReader, RefusesTheBadGoldensAsStoreReaderDoes) {
  int stores = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(VT_SOURCE_DIR) / "tests/golden/bad")) {
    ++stores;
    EXPECT_EQ(difference(entry.path(), read_file(entry.path()), {{LayerId{0}, TileId{}}}), "") << entry.path().filename();
  }
  EXPECT_GT(stores, 0);
}

}  // namespace
}  // namespace vt::test
