// The golden stores and the format document's hex dump. To write them anew after a change of the format, and
// see in git what changed:
//   VT_REWRITE_GOLDENS=1 build/dev/bin/store_test --gtest_filter='Golden*'
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <set>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/reseal.h"
#include "tests/store/store_support.h"
#include "tests/support/format_lists.h"

namespace vt::store {
namespace {

using namespace test;

const std::filesystem::path kSource = VT_SOURCE_DIR;

bool is_rewriting() { return std::getenv("VT_REWRITE_GOLDENS") != nullptr; }

// Stores get a random UUID; goldens must not.
void set_uuid(Bytes& store) {
  for (const std::size_t slot : {std::size_t{0}, kSuperblockBytes})
    for (std::size_t i = 0; i < 16; ++i) store[slot + 16 + i] = static_cast<std::byte>(i * 0x11);
  reseal(store);
}

// One layer of one 4x4 RGB8 tile: every structure once.
Bytes smallest_store() {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 0);
  layer.transfer = Transfer::kSrgb;
  const LayerId id = value_of(writer.add_layer(layer));
  Bytes tile(layer.tile_payload_bytes());
  for (std::size_t i = 0; i < tile.size(); ++i) tile[i] = static_cast<std::byte>(i);
  succeed(writer.put(id, {}, encoded(tile)));
  succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.finish());
  Bytes bytes = read_file(folder / "a.vts");
  set_uuid(bytes);
  return bytes;
}

// One frame with one raw block (RFC 8878), so that the golden does not depend on how some zstd compresses.
Bytes uncompressed_frame(std::span<const std::byte> bytes) {
  const std::size_t size = bytes.size();
  assert(size >= 256 && size < 65536);
  // Magic number; one segment, its size in two bytes, less 256; then the block: raw, and the last one.
  Bytes frame(10 + size);
  put<std::uint32_t>(frame, 0, 0xFD2FB528);
  put<std::uint8_t>(frame, 4, 0x60);
  put<std::uint16_t>(frame, 5, static_cast<std::uint16_t>(size - 256));
  put<std::uint16_t>(frame, 7, static_cast<std::uint16_t>(size << 3 | 1));
  put<std::uint8_t>(frame, 9, static_cast<std::uint8_t>(size >> 13));
  std::copy(bytes.begin(), bytes.end(), frame.begin() + 10);
  return frame;
}

// Two layers of one predicted tile: of floats, in a format that a changed number makes hashes, and of bytes,
// with every kind of choice.
Contents predicted_contents;
Bytes predicted_store() {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const auto put = [&](const LayerInfo& layer, const Prediction& prediction, std::span<const std::byte> tile) {
    const TileShape shape = tile_shape(layer.format, layer.tile_texels());
    Bytes planes(shape.raw_bytes());
    split_into_residuals(tile, shape, prediction, planes);
    const Bytes frame = uncompressed_frame(planes);
    EncodedPayload payload{.codec = Codec::kPredictedZstd, .raw_bytes = static_cast<std::uint32_t>(tile.size()), .bytes = {}};
    payload.bytes.resize(1 + shape.channels + frame.size());
    payload.bytes[0] = prediction.subtracts_green ? std::byte{1} : std::byte{0};
    for (std::size_t c = 0; c < shape.channels; ++c) payload.bytes[1 + c] = static_cast<std::byte>(prediction.predictors[c]);
    std::copy(frame.begin(), frame.end(), payload.bytes.begin() + 1 + static_cast<std::ptrdiff_t>(shape.channels));
    const LayerId id = value_of(writer.add_layer(layer));
    succeed(writer.put(id, {}, payload));
    succeed(writer.set_state(id, LayerState::kComplete));
    predicted_contents[{layer.name, TileId{}}] = Bytes(tile.begin(), tile.end());
  };
  const LayerInfo floats = small_layer("floats", TexelFormat::kRgba32Float, 2, 0);
  put(floats, {false, {Predictor::kGradient, Predictor::kUp, Predictor::kMedian, Predictor::kAverage}}, smooth_tile_bytes(floats, {}));
  const LayerInfo color = small_layer("color", TexelFormat::kRgba8, 3, 0);
  put(color, {true, {Predictor::kAverage, Predictor::kMedian, Predictor::kLeft, Predictor::kNone}}, smooth_tile_bytes(color, {}));
  succeed(writer.finish());
  Bytes bytes = read_file(folder / "a.vts");
  set_uuid(bytes);
  return bytes;
}

// Three equal tiles and one that is not, raw.
Contents shared_contents;
Bytes shared_store() {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 1);
  const LayerId id = value_of(writer.add_layer(layer));
  const std::vector<TileId> tiles = {tile_at(0, 0, 0), tile_at(1, 0, 0), tile_at(1, 1, 0), tile_at(1, 1, 1)};
  for (const TileId tile : tiles) {
    shared_contents[{"color", tile}] = tile_bytes(layer, {}, tile == tiles[1] ? 1 : 2);
    succeed(writer.put(id, tile, encoded(shared_contents[{"color", tile}])));
  }
  succeed(writer.set_state(id, LayerState::kComplete));
  succeed(writer.finish());
  Bytes bytes = read_file(folder / "a.vts");
  set_uuid(bytes);
  return bytes;
}

// The formats of the golden stores, those of older versions too: the ones that there were when they were
// made. A newer format is in none of them.
std::vector<TexelFormat> golden_formats() {
  return vt::test::formats_where([](const FormatInfo& info) { return info.format < TexelFormat::kBlob; });
}

Bytes some_bytes(std::size_t count) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * i + 7);
  return bytes;
}

// A texture layer without tiles, and one blob that it owns.
Bytes blob_store() {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  LayerInfo blobs = small_layer("notes", TexelFormat::kBlob, 2, 0);
  blobs.role = LayerRole::kCarry;
  blobs.owner = value_of(writer.add_layer(small_layer("color", TexelFormat::kRgb8, 2, 0)));
  const LayerId id = value_of(writer.add_layer(blobs));
  succeed(writer.put(id, {}, PayloadView(Codec::kZstd, 300, uncompressed_frame(some_bytes(300)))));
  succeed(writer.finish());
  Bytes bytes = read_file(folder / "a.vts");
  set_uuid(bytes);
  return bytes;
}

// Every format, raw, compressed and constant tiles, a part, carry layers, one of them of blobs, an index two
// pages deep, an older generation.
Contents rich_contents;
Bytes rich_store() {
  const TempFolder folder;
  Contents& truth = rich_contents;
  truth.clear();
  StoreWriter writer = value_of(StoreWriter::create(
      folder / "a.vts", {.area = {.west = 178.0, .south = -18.0, .east = 182.0, .north = -16.0}, .metadata_json = R"({"note":"golden"})"}));
  const auto put = [&](const LayerInfo& layer, LayerId id, TileId tile, Compression compression) {
    truth[{layer.name, tile}] = tile_bytes(layer, tile);
    succeed(writer.put(id, tile, encoded(truth[{layer.name, tile}], compression)));
  };
  int number = 0;
  for (const TexelFormat format : golden_formats()) {
    LayerInfo layer = small_layer(std::string(format_info(format).name), format, 3, 1);
    if (format == TexelFormat::kR16) {
      layer.zero_is_nodata = true;
      layer.components[0] = {.scale = 0.25, .offset = -1000.0};
    }
    if (format == TexelFormat::kRg8) {
      layer.is_part = true;
      layer.owner = {0};
    }
    const LayerId id = value_of(writer.add_layer(layer));
    put(layer, id, tile_at(0, 0, 0), {});
    put(layer, id, tile_at(1, static_cast<std::uint32_t>(number % 2), 1), {Codec::kZstd, 3});
    Bytes constant(layer.tile_payload_bytes());
    const std::size_t block = format_info(format).block_bytes;
    for (std::size_t i = 0; i < constant.size(); ++i) constant[i] = static_cast<std::byte>(i % block + 1);
    const TileId tile = tile_at(1, static_cast<std::uint32_t>(number % 2), 0);
    succeed(writer.put_constant(id, tile, std::span(constant).first(block)));
    truth[{layer.name, tile}] = constant;
    succeed(writer.set_state(id, LayerState::kComplete));
    ++number;
  }
  succeed(writer.commit());
  LayerInfo carry = small_layer("rgb8 carry", TexelFormat::kRgba32Float, 2, 1);
  carry.role = LayerRole::kCarry;
  carry.owner = {0};
  const LayerId carry_id = value_of(writer.add_layer(carry));
  put(carry, carry_id, tile_at(1, 1, 1), {});
  LayerInfo blobs = small_layer("rgb8 notes", TexelFormat::kBlob, 3, 1);
  blobs.role = LayerRole::kCarry;
  blobs.owner = {0};
  const LayerId blobs_id = value_of(writer.add_layer(blobs));
  for (const std::uint32_t x : {0U, 1U}) {
    truth[{blobs.name, tile_at(1, x, 0)}] = some_bytes(x == 0 ? 1 : 1000);
    succeed(writer.put(blobs_id, tile_at(1, x, 0), encoded(truth[{blobs.name, tile_at(1, x, 0)}], {Codec::kZstd, 3})));
  }
  LayerInfo deep = small_layer("deep", TexelFormat::kRgb8, 2, 6);
  deep.channel = ChannelType::kElevation;
  deep.metadata_json = R"({"levels":7})";
  const LayerId deep_id = value_of(writer.add_layer(deep));
  for (int level = 0; level <= 6; ++level) put(deep, deep_id, tile_at(level, (1U << level) - 1, 0), {});
  succeed(writer.set_state(deep_id, LayerState::kComplete));
  for (const TexelFormat format : golden_formats()) {
    if (!tile_shape(format, 1).is_predictable()) continue;
    const LayerInfo layer = small_layer("smooth " + std::string(format_info(format).name), format, 4, 0);
    const LayerId id = value_of(writer.add_layer(layer));
    truth[{layer.name, TileId{}}] = smooth_tile_bytes(layer, {});
    succeed(writer.put(id, {}, encoded(layer, truth[{layer.name, TileId{}}], {Codec::kZstd, 1})));
    succeed(writer.set_state(id, LayerState::kComplete));
  }
  succeed(writer.finish());
  Bytes bytes = read_file(folder / "a.vts");
  set_uuid(bytes);
  return bytes;
}

std::uint64_t catalog_payload(const Bytes& store) {
  const auto superblock = choose_superblock(std::span(store).first(kLogStart), store.size());
  return superblock->newest.catalog.offset + kRecordHeaderBytes;
}
Reference root_of(const Bytes& store, std::size_t layer, std::size_t level) {
  const Superblock superblock = choose_superblock(std::span(store).first(kLogStart), store.size())->newest;
  const auto payload = std::span(store).subspan(catalog_payload(store)).first(superblock.catalog.stored_bytes);
  return decode_catalog(payload, store.size(), superblock.version)->layers[layer].roots[level];
}

// The only tile of a layer of a small store.
Reference tile_of(const Bytes& store, std::size_t layer = 0) {
  const Reference page = root_of(store, layer, 0);
  return page_entry(std::span(store).subspan(page.offset + kRecordHeaderBytes, page.stored_bytes), 0);
}

// What newer programs and users may leave: a channel of a user's own, one of a newer program, and a layer of
// a format of a newer program that shares a record with one that we know, and owns a carry layer.
Bytes unknown_store() {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}));
  const auto add = [&](LayerInfo layer) {
    const LayerId id = value_of(writer.add_layer(layer));
    succeed(writer.set_state(id, LayerState::kComplete));
    return id;
  };
  const LayerInfo color = small_layer("color", TexelFormat::kRgba8, 3, 1);
  const LayerId color_id = add(color);
  LayerInfo aspect = small_layer("aspect", TexelFormat::kRg16, 2, 0);
  aspect.channel = static_cast<ChannelType>(kFirstPrivateChannel + 1);
  const LayerId aspect_id = add(aspect);
  LayerInfo later = small_layer("later", TexelFormat::kRgb8, 2, 1);
  const LayerId later_id = add(later);
  LayerInfo strange = small_layer("strange", TexelFormat::kRgba8, 3, 1);
  strange.zero_is_nodata = true;
  const LayerId strange_id = add(strange);
  LayerInfo notes = small_layer("strange notes", TexelFormat::kBlob, 2, 0);
  notes.role = LayerRole::kCarry;
  notes.owner = strange_id;
  const LayerId notes_id = add(notes);

  const Bytes root = tile_bytes(color, {});
  succeed(writer.put(color_id, {}, encoded(root)));
  succeed(writer.put(color_id, tile_at(1, 1, 0), encoded(tile_bytes(color, tile_at(1, 1, 0)))));
  succeed(writer.put(aspect_id, {}, encoded(tile_bytes(aspect, {}))));
  for (const TileId tile : {tile_at(0, 0, 0), tile_at(1, 1, 1)}) succeed(writer.put(later_id, tile, encoded(tile_bytes(later, tile))));
  succeed(writer.put(strange_id, {}, encoded(root)));
  succeed(
      writer.put(strange_id, tile_at(1, 0, 0), PayloadView(Codec::kZstd, 256, uncompressed_frame(tile_bytes(strange, tile_at(1, 0, 0))))));
  succeed(writer.put_constant(strange_id, tile_at(1, 1, 0), some_bytes(4)));
  succeed(writer.put(notes_id, {}, encoded(some_bytes(5))));
  succeed(writer.finish());

  Bytes bytes = read_file(folder / "a.vts");
  const auto entry = [&](LayerId id) { return catalog_payload(bytes) + 48 + std::uint64_t{id.value} * 192; };
  put<std::uint16_t>(bytes, entry(later_id) + 2, 4711);
  put<std::uint16_t>(bytes, entry(strange_id) + 4, 999);
  set_uuid(bytes);
  return bytes;
}

// Each fault is one change to a good store, which is then sealed again where the fault lies behind a
// checksum.
struct Bad {
  Bytes (*store)();
  const char* name;
  int finding;
  bool opens;  // the reader notices when it comes to the damaged part, not before
  std::function<void(Bytes&)> spoil;
};

const std::vector<Bad>& bad_stores() {
  static const std::vector<Bad> bad = {
      {smallest_store, "both-superblocks-damaged", 102, false,
       [](Bytes& s) {
         s[40] ^= std::byte{1};
         s[kSuperblockBytes + 40] ^= std::byte{1};
       }},
      {smallest_store, "later-version", 103, false,
       [](Bytes& s) {
         put<std::uint32_t>(s, 8, kFormatVersion + 1);
         reseal(s);
       }},
      {smallest_store, "reserved-bytes-set", 104, false,
       [](Bytes& s) {
         s[2000] = std::byte{1};
         reseal(s);
       }},
      {smallest_store, "truncated", 105, false, [](Bytes& s) { s.erase(s.end() - 64, s.end()); }},
      {smallest_store, "catalog-checksum", 202, false, [](Bytes& s) { s[catalog_payload(s) + 100] ^= std::byte{1}; }},
      {smallest_store, "layer-tile-exponent", 204, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 9] = std::byte{13};
         reseal(s);
       }},
      {smallest_store, "layer-without-channel", 204, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 2] = std::byte{0};
         reseal(s);
       }},
      {smallest_store, "layer-without-format", 204, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 4] = std::byte{0};
         reseal(s);
       }},
      {smallest_store, "layer-flags", 203, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 14] = std::byte{4};
         reseal(s);
       }},
      {smallest_store, "component-scale", 204, false,
       [](Bytes& s) {
         put_f64(s, catalog_payload(s) + 48 + 128, 0.0);
         reseal(s);
       }},
      {smallest_store, "part-of-itself", 205, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 14] = std::byte{1};
         reseal(s);
       }},
      {smallest_store, "blobs-as-texture", 204, false,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 4] = std::byte{22};
         reseal(s);
       }},
      {blob_store, "blob-of-no-bytes", 401, true,
       [](Bytes& s) {
         const std::uint64_t record = tile_of(s, 1).offset;
         put<std::uint32_t>(s, record + 16, 0);
         reseal(s);
       }},
      {blob_store, "blob-longer-than-its-frame", 402, true,
       [](Bytes& s) {
         s[tile_of(s, 1).offset + 16] ^= std::byte{1};
         reseal(s);
       }},
      {smallest_store, "page-rank", 303, true,
       [](Bytes& s) {
         s[root_of(s, 0, 0).offset + kRecordHeaderBytes + kPageRanksAt + 4] ^= std::byte{1};
         reseal(s);
       }},
      {smallest_store, "page-entry-outside-file", 304, true,
       [](Bytes& s) {
         s[root_of(s, 0, 0).offset + kRecordHeaderBytes + kPageEntriesAt + 4] = std::byte{9};
         reseal(s);
       }},
      {smallest_store, "tile-checksum", 401, true, [](Bytes& s) { s[tile_of(s).offset + kRecordHeaderBytes + 7] ^= std::byte{1}; }},
      {smallest_store, "counts", 502, true,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 96] = std::byte{7};
         reseal(s);
       }},
      {shared_store, "shared-tile-key", 401, true,
       [](Bytes& s) {
         s[tile_of(s).offset + 24] = std::byte{1};
         reseal(s);
       }},
      {shared_store, "shared-tile-raw-bytes", 401, true,
       [](Bytes& s) {
         s[tile_of(s).offset + 16] ^= std::byte{1};
         reseal(s);
       }},
      {predicted_store, "predictor-unknown", 402, true,
       [](Bytes& s) {
         s[tile_of(s).offset + kRecordHeaderBytes + 2] = std::byte{6};
         reseal(s);
       }},
      {predicted_store, "predicted-green-of-floats", 402, true,
       [](Bytes& s) {
         s[tile_of(s).offset + kRecordHeaderBytes] = std::byte{1};
         reseal(s);
       }},
      {predicted_store, "predicted-hashes", 402, true,
       [](Bytes& s) {
         s[catalog_payload(s) + 48 + 4] = std::byte{7};
         reseal(s);
       }},
  };
  return bad;
}

void compare_or_rewrite(const std::filesystem::path& path, const Bytes& wanted) {
  if (is_rewriting()) {
    std::filesystem::create_directories(path.parent_path());
    write_file(path, wanted);
  }
  EXPECT_EQ(read_file(path), wanted) << path << " differs from what this writer makes";
}

TEST(Golden, TheSmallestStoreIsWrittenByteForByte) { compare_or_rewrite(kSource / "tests/golden/smallest.vts", smallest_store()); }

TEST(Golden, ThePredictedStoreIsWrittenByteForByte) {
  const auto path = kSource / "tests/golden/predicted.vts";
  compare_or_rewrite(path, predicted_store());
  EXPECT_EQ(read_all(value_of(StoreReader::open(path))), predicted_contents);
  EXPECT_TRUE(value_of(validate(path)).ok());
}

TEST(Golden, TheSharedStoreIsWrittenByteForByte) {
  const auto path = kSource / "tests/golden/shared.vts";
  compare_or_rewrite(path, shared_store());
  EXPECT_EQ(read_all(value_of(StoreReader::open(path))), shared_contents);
  EXPECT_TRUE(value_of(validate(path)).ok());
  EXPECT_EQ(tile_of(read_file(path)).kind, ReferenceKind::kSharedTile);
}

// What is read of it: unknown_number_test.cpp.
TEST(Golden, TheStoreOfUnknownNumbersIsWrittenByteForByte) {
  compare_or_rewrite(kSource / "tests/golden/unknown-numbers.vts", unknown_store());
}

TEST(Golden, TheRichStoreReadsBackWhateverThisWriterWouldMake) {
  const Bytes fresh = rich_store();  // also the truth
  if (is_rewriting()) write_file(kSource / "tests/golden/rich.vts", fresh);
  // Another zstd may compress in other words, so the golden's bytes are not compared, only what they say.
  const StoreReader reader = value_of(StoreReader::open(kSource / "tests/golden/rich.vts"));
  EXPECT_EQ(read_all(reader), rich_contents);
  EXPECT_EQ(reader.uuid(), "00112233-4455-6677-8899-aabbccddeeff");
  EXPECT_EQ(reader.generation(), 5U);
  EXPECT_EQ(reader.description().area.east, 182.0);
  EXPECT_EQ(reader.find_layer("deep")->metadata_json, R"({"levels":7})");
  EXPECT_EQ(reader.find_layer("rgb8 carry")->owner, LayerId{0});
  EXPECT_EQ(reader.find_layer("r16")->components[0], (ComponentRange{.scale = 0.25, .offset = -1000.0}));
  EXPECT_TRUE(reader.find_layer("r16")->zero_is_nodata);
  EXPECT_TRUE(reader.find_layer("rg8")->is_part);
  for (const LayerInfo& layer : reader.layers()) {
    if (!layer.name.starts_with("smooth ")) continue;
    EXPECT_EQ(value_of(reader.lookup(layer.id, {})).codec, Codec::kPredictedZstd) << layer.name;
  }
  const auto report = value_of(validate(kSource / "tests/golden/rich.vts"));
  EXPECT_TRUE(report.ok());
  std::set<int> numbers;
  for (const Finding& finding : report.findings) numbers.insert(finding.number);
  EXPECT_EQ(numbers, (std::set<int>{501}));  // the carry layer is unfinished
}

// Stores that writers of older versions left; nothing can write them any more. They had the tiles of today's
// except for what came later.
TEST(Golden, StoresOfOlderVersionsAreReadAsEver) {
  static_cast<void>(rich_store());  // the truth
  static_cast<void>(predicted_store());
  static_cast<void>(shared_store());
  const auto golden = [](const std::string& name) { return kSource / "tests/golden" / (name + ".vts"); };
  const auto contents = [&](const std::string& name) {
    EXPECT_TRUE(value_of(validate(golden(name))).ok()) << name;
    const StoreReader reader = value_of(StoreReader::open(golden(name)));
    for (const LayerInfo& layer : reader.layers()) {
      if (name.starts_with("version-3")) continue;
      EXPECT_EQ(layer.components, LayerInfo().components) << name;
      EXPECT_FALSE(layer.is_part || layer.zero_is_nodata) << name;
    }
    return read_all(reader);
  };
  EXPECT_EQ(contents("version-3-rich"), rich_contents);
  for (const std::string version : {"version-1-", "version-2-"}) {
    EXPECT_EQ(contents(version + "smallest"), contents("smallest"));
    const Contents rich = contents(version + "rich");
    EXPECT_EQ(rich.size(), version == "version-1-" ? 26U : 34U);
    for (const auto& [place, bytes] : rich) EXPECT_EQ(bytes, rich_contents.at(place)) << version << place.first;
  }
  EXPECT_EQ(contents("version-2-predicted"), predicted_contents);
  EXPECT_EQ(contents("version-2-shared"), shared_contents);
}

class GoldenOfVersion : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Golden, GoldenOfVersion, testing::Values(1U, 2U, 3U));

TEST_P(GoldenOfVersion, GoesOnAsTheNewest) {
  const TempFolder folder;
  const auto path = folder / "a.vts";
  std::filesystem::copy_file(kSource / "tests/golden" / ("version-" + std::to_string(GetParam()) + "-rich.vts"), path);
  Contents wanted = read_all(value_of(StoreReader::open(path)));
  LayerInfo hashes = small_layer("hashes", TexelFormat::kHash128, 2, 1);
  // Opened and not changed, it keeps its catalog, and its version when that tells what the catalog is like.
  succeed(value_of(StoreWriter::open(path)).finish());
  EXPECT_EQ(get<std::uint32_t>(read_file(path), 8), GetParam() < 3 ? GetParam() : kFormatVersion);
  EXPECT_EQ(read_all(value_of(StoreReader::open(path))), wanted);
  for (int commits = 0; commits < 2; ++commits) {
    StoreWriter writer = value_of(StoreWriter::open(path));
    const LayerId id = commits == 0 ? value_of(writer.add_layer(hashes)) : writer.find_layer("hashes")->id;
    const TileId tile = tile_at(1, 0, static_cast<std::uint32_t>(commits));
    wanted[{"hashes", tile}] = tile_bytes(hashes, tile);
    succeed(writer.put(id, tile, encoded(wanted[{"hashes", tile}])));
    succeed(writer.finish());
    EXPECT_EQ(read_all(value_of(StoreReader::open(path))), wanted);
    EXPECT_TRUE(value_of(validate(path)).ok());
    const Bytes bytes = read_file(path);
    const auto newest = choose_superblock(std::span(bytes).first(kLogStart), bytes.size());
    ASSERT_TRUE(newest);
    EXPECT_EQ(newest->newest.version, kFormatVersion);
    EXPECT_EQ(newest->other->version, kFormatVersion);
    EXPECT_TRUE(newest->is_pair());
  }
}

TEST(Golden, EveryBadStoreIsRefusedForItsOwnFault) {
  for (const Bad& bad : bad_stores()) {
    Bytes bytes = bad.store();
    bad.spoil(bytes);
    const auto path = kSource / "tests/golden/bad" / (std::string(bad.name) + ".vts");
    compare_or_rewrite(path, bytes);

    const auto report = value_of(validate(path));
    EXPECT_FALSE(report.ok()) << bad.name;
    std::set<int> errors;
    for (const Finding& finding : report.findings)
      if (finding.is_error) errors.insert(finding.number);
    EXPECT_EQ(errors, std::set<int>{bad.finding}) << bad.name;
    const auto reader = StoreReader::open(path);
    EXPECT_EQ(reader.has_value(), bad.opens) << bad.name;
    if (!reader) {
      EXPECT_THAT(reader.error().message, testing::HasSubstr(path.filename().string()));
    }
    if (reader && bad.finding < 500) {
      const bool is_blob = reader->layers().back().holds_blobs();
      Bytes out(reader->layers()[0].tile_payload_bytes());
      const auto read = is_blob ? reader->read_blob(reader->layers().back().id, {}, out) : reader->read(LayerId{0}, {}, out);
      ASSERT_FALSE(read) << bad.name;
      EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
    }
  }
}

// ---- The hex dump in the document ----

std::string dump(const Bytes& store) {
  const Superblock b = choose_superblock(std::span(store).first(kLogStart), store.size())->newest;
  const std::uint64_t catalog = b.catalog.offset;
  const Reference page = root_of(store, 0, 0);
  const Reference tile = tile_of(store);
  std::string text;
  const auto section = [&](const std::string& title, std::uint64_t start, const std::vector<std::pair<std::size_t, std::string>>& parts) {
    text += "\n" + title + "\n";
    std::uint64_t at = start;
    for (const auto& [bytes, meaning] : parts) {
      std::string hex;
      const bool is_zero = all_zero(std::span(store).subspan(at, bytes));
      for (std::size_t i = 0; i < bytes && i < 16; ++i) {
        char two[4];
        std::snprintf(two, sizeof two, "%02x ", std::to_integer<unsigned>(store[at + i]));
        hex += two;
      }
      if (bytes > 16) hex = is_zero ? "00 (" + std::to_string(bytes) + " times) " : hex + "... ";
      char line[160];
      std::snprintf(line, sizeof line, "%6llu  %-53s%s\n", static_cast<unsigned long long>(at), hex.c_str(), meaning.c_str());
      text += line;
      at += bytes;
    }
  };
  const auto superblock = [&](const std::string& title, std::uint64_t start) {
    section(title, start,
            {{8, "magic \"VTSTORE1\""},
             {4, "version 4"},
             {4, "reserved"},
             {16, "UUID"},
             {8, "generation"},
             {8, "file end"},
             {16, "reference to the catalog"},
             {16, "cold start: none"},
             {8, "ignorable"},
             {8, "catalog space"},
             {16, "spare catalog: that of generations 0 and 1"},
             {16, "ignorable"},
             {3960, "reserved"},
             {8, "hash of the 4088 bytes before"}});
  };
  const auto header = [](const std::string& type) {
    return std::vector<std::pair<std::size_t, std::string>>{{8, "hash of all that follows, padding excluded"},
                                                            {4, "magic \"VTRC\""},
                                                            {1, "type: " + type},
                                                            {1, "codec: raw"},
                                                            {2, "reserved"},
                                                            {4, "raw bytes"},
                                                            {4, "stored bytes"},
                                                            {8, "key"}};
  };
  const auto record = [&](const std::string& title, const Reference& reference, const std::string& type,
                          std::vector<std::pair<std::size_t, std::string>> payload) {
    auto parts = header(type);
    parts.insert(parts.end(), payload.begin(), payload.end());
    if (const std::size_t pad = reference.record_bytes() - kRecordHeaderBytes - reference.stored_bytes; pad > 0)
      parts.emplace_back(pad, "padding");
    section(title, reference.offset, parts);
  };
  superblock("superblock A: generation 2", 0);
  superblock("superblock B: generation 3, the same state", kSuperblockBytes);
  const Reference first{.offset = kLogStart, .stored_bytes = get<std::uint32_t>(store, kLogStart + 20)};
  record("catalog of generations 0 and 1: no layers (garbage by now)", first, "catalog",
         {{4, "layers: 0"},
          {4, "metadata bytes: 2"},
          {8, "west 0.0"},
          {8, "south 0.0"},
          {8, "east 1.0"},
          {8, "north 1.0"},
          {8, "reserved"},
          {2, "metadata \"{}\""}});
  record("tile: layer 0, level 0, column 0, row 0", tile, "tile", {{48, "4 x 4 texels of 3 bytes: 00 01 02 ... 2f"}});
  record("index page: the root, and only leaf, of layer 0, level 0", page, "page",
         {{2, "entries: 1"},
          {1, "height: 0, a leaf"},
          {13, "reserved"},
          {128, "presence: slot 0 only"},
          {2, "rank of word 0: 0"},
          {30, "ranks of words 1 to 15: 1 each"},
          {16, "entry: reference to the tile"}});
  record("catalog of generations 2 and 3", b.catalog, "catalog",
         {{4, "layers: 1"},
          {4, "metadata bytes: 2"},
          {8, "west 0.0"},
          {8, "south 0.0"},
          {8, "east 1.0"},
          {8, "north 1.0"},
          {8, "reserved"},
          {2, "layer id: 0"},
          {2, "channel type: color"},
          {2, "texel format: rgb8"},
          {1, "transfer: sRGB"},
          {1, "role: texture"},
          {1, "state: complete"},
          {1, "tile exponent: 2"},
          {1, "finest level: 0"},
          {1, "name bytes: 5"},
          {2, "owner: none"},
          {1, "flags: none"},
          {1, "ignorable"},
          {4, "metadata bytes: 0"},
          {4, "reserved"},
          {8, "data x: 0"},
          {8, "data y: 0"},
          {8, "data width: 4"},
          {8, "data height: 4"},
          {8, "origin x 0.0"},
          {8, "origin y 1.0"},
          {8, "step x 0.25"},
          {8, "step y 0.25"},
          {8, "source nodata: NaN"},
          {8, "tiles: 1"},
          {8, "constant tiles: 0"},
          {8, "stored bytes: 128"},
          {8, "reserved"},
          {8, "component 0: scale 1.0"},
          {8, "component 0: offset 0.0"},
          {8, "component 1: scale 1.0"},
          {8, "component 1: offset 0.0"},
          {8, "component 2: scale 1.0"},
          {8, "component 2: offset 0.0"},
          {8, "component 3: scale 1.0"},
          {8, "component 3: offset 0.0"},
          {16, "root of level 0: reference to the page"},
          {2, "metadata \"{}\""},
          {5, "name \"color\""}});
  text += "\n" + std::to_string(store.size()) + " bytes in all\n";
  EXPECT_EQ(catalog + b.catalog.record_bytes(), store.size());
  return text;
}

TEST(Golden, TheDocumentShowsTheSmallestStore) {
  const auto path = kSource / "schemas/tile-store.md";
  const Bytes raw = read_file(path);
  std::string document(reinterpret_cast<const char*>(raw.data()), raw.size());
  const std::string begin = "<!-- dump: begin -->\n```text";
  const std::string end = "```\n<!-- dump: end -->";
  const std::size_t from = document.find(begin);
  const std::size_t to = document.find(end);
  ASSERT_NE(from, std::string::npos);
  ASSERT_NE(to, std::string::npos);
  const std::string wanted = dump(smallest_store());
  if (is_rewriting()) {
    document.replace(from + begin.size(), to - from - begin.size(), wanted);
    write_file(path, std::as_bytes(std::span(document)));
    return;
  }
  EXPECT_EQ(document.substr(from + begin.size(), to - from - begin.size()), wanted);
}

// A fault that can be found has a line in the document.
TEST(Golden, TheDocumentListsEveryFindingNumber) {
  const Bytes raw = read_file(kSource / "schemas/tile-store.md");
  const std::string document(reinterpret_cast<const char*>(raw.data()), raw.size());
  for (const int number : {101, 102, 103, 104, 105, 106, 107, 108, 109, 110, 199, 201, 202, 203, 204,
                           205, 301, 302, 303, 304, 401, 402, 403, 404, 501, 502, 503, 504, 505})
    EXPECT_THAT(document, testing::HasSubstr("| " + std::to_string(number) + " |"));
}

}  // namespace
}  // namespace vt::store
