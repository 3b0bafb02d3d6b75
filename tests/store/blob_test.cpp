// Layers of blobs: any bytes of any length come back, and no record of one is anybody else's.
#include <gtest/gtest.h>

#include <random>

#include "store/format/catalog.h"
#include "store/format/layout.h"
#include "store/pack.h"
#include "store/region.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

TileId tile_at(int level, std::uint32_t x, std::uint32_t y) { return {Level{static_cast<std::uint8_t>(level)}, x, y}; }

struct BlobStore {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";
  StoreWriter writer = value_of(StoreWriter::create(path, {}));
  LayerId color = value_of(writer.add_layer(small_layer("color", TexelFormat::kRgb8, 2, 3)));
  LayerId blobs = value_of(writer.add_layer(layer()));

  static LayerInfo layer() {
    LayerInfo info = small_layer("notes", TexelFormat::kBlob, 2, 3);
    info.role = LayerRole::kCarry;
    return info;
  }
  [[nodiscard]] Result<void> put(TileId tile, const Bytes& blob, Compression compression) {
    std::vector<std::byte> scratch;
    VT_ASSIGN(const PayloadView payload, encode_payload(blob, compression, scratch));
    return writer.put(blobs, tile, payload);
  }
};

// Half random and half zeros, so that zstd gains something from 100 bytes on.
Bytes blob_of(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(count);
  for (std::size_t i = 0; i < count / 2; ++i) bytes[i] = static_cast<std::byte>(random());
  if (count > 0) bytes.back() = static_cast<std::byte>(seed);
  return bytes;
}

TEST(Blob, ComesBackWhateverItsLength) {
  BlobStore store;
  Contents truth;
  unsigned number = 0;
  for (const std::size_t count : {1U, 2U, 48U, 63U, 64U, 65U, 1000U, 100000U, 5000000U}) {
    const TileId tile = tile_at(3, number % 8, number / 8);
    truth[{"notes", tile}] = blob_of(count, number);
    succeed(store.put(tile, truth[{"notes", tile}], number % 2 == 0 ? Compression{} : Compression{Codec::kZstd, 3}));
    Bytes back;
    succeed(store.writer.read_blob(store.blobs, tile, back));
    EXPECT_EQ(back, (truth[{"notes", tile}]));
    ++number;
  }
  for (const LayerId id : {store.color, store.blobs}) succeed(store.writer.set_state(id, LayerState::kComplete));
  succeed(store.writer.finish());
  const StoreReader reader = value_of(StoreReader::open(store.path));
  EXPECT_EQ(read_all(reader), truth);
  EXPECT_TRUE(value_of(validate(store.path)).ok());
  EXPECT_EQ(value_of(reader.lookup(store.blobs, tile_at(3, 7, 0))).codec, Codec::kZstd);

  static_cast<void>(value_of(pack(reader, store.folder / "b.vts", {.keep_carry = true})));
  EXPECT_EQ(read_all(value_of(StoreReader::open(store.folder / "b.vts"))), truth);
  EXPECT_TRUE(value_of(validate(store.folder / "b.vts")).ok());
}

TEST(Blob, IsReplacedFoundAndRemoved) {
  BlobStore store;
  std::vector<std::byte> scratch;
  const Bytes first = blob_of(300, 1);
  const Bytes second = blob_of(7000, 2);
  succeed(store.put({}, first, {}));
  succeed(store.put({}, second, {Codec::kZstd, 1}));
  Bytes back;
  succeed(store.writer.read_blob(store.blobs, {}, back));
  EXPECT_EQ(back, second);
  EXPECT_TRUE(value_of(store.writer.holds(store.blobs, {}, value_of(encode_payload(second, {Codec::kZstd, 1}, scratch)))));
  EXPECT_FALSE(value_of(store.writer.holds(store.blobs, {}, value_of(encode_payload(first, Compression{}, scratch)))));
  succeed(store.writer.remove(store.blobs, {}));
  EXPECT_EQ(store.writer.read_blob(store.blobs, {}, back).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(value_of(store.writer.holds(store.blobs, {}, value_of(encode_payload(first, Compression{}, scratch)))));
}

// Equal tiles share their records; a blob that happens to be the same bytes does not join them.
TEST(Blob, SharesItsRecordWithNoTileAndNoBlob) {
  BlobStore store;
  const Bytes tile = tile_bytes(small_layer("color", TexelFormat::kRgb8, 2, 3), {});
  const auto offset = [&](const StoreReader& reader, LayerId layer, TileId at) { return value_of(reader.lookup(layer, at)).offset; };
  succeed(store.writer.put(store.color, tile_at(0, 0, 0), encoded(tile)));
  succeed(store.put(tile_at(0, 0, 0), tile, {}));
  succeed(store.put(tile_at(1, 0, 0), tile, {}));
  succeed(store.writer.put(store.color, tile_at(1, 0, 0), encoded(tile)));
  succeed(store.writer.finish());
  const StoreReader reader = value_of(StoreReader::open(store.path));
  EXPECT_EQ(offset(reader, store.color, tile_at(0, 0, 0)), offset(reader, store.color, tile_at(1, 0, 0)));
  EXPECT_NE(offset(reader, store.blobs, tile_at(0, 0, 0)), offset(reader, store.blobs, tile_at(1, 0, 0)));
  EXPECT_EQ(read_all(reader).size(), 4U);
  EXPECT_TRUE(value_of(validate(store.path)).ok());
}

TEST(Blob, IsNoTextureAndNoTexels) {
  BlobStore store;
  LayerInfo texture = BlobStore::layer();
  texture.name = "texture";
  texture.role = LayerRole::kTexture;
  EXPECT_EQ(store.writer.add_layer(texture).error().code, ErrorCode::kInvalidData);
  EXPECT_EQ(store.put({}, {}, {}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(store.writer.put_constant(store.blobs, {}, {}).error().code, ErrorCode::kUsage);
  const Bytes bytes = blob_of(50, 1);
  EXPECT_EQ(store.writer.put(store.blobs, {}, PayloadView(Codec::kPredictedZstd, 50, bytes)).error().code, ErrorCode::kUsage);
  EXPECT_EQ(store.writer.put(store.blobs, {}, PayloadView(Codec::kRaw, 51, bytes)).error().code, ErrorCode::kUsage);
  succeed(store.put({}, bytes, {}));
  Bytes out;
  EXPECT_EQ(store.writer.read(store.blobs, {}, out).error().code, ErrorCode::kUsage);
  EXPECT_EQ(store.writer.read_blob(store.color, {}, out).error().code, ErrorCode::kUsage);
  succeed(store.writer.finish());
  const StoreReader reader = value_of(StoreReader::open(store.path));
  EXPECT_EQ(reader.read(store.blobs, {}, out).error().code, ErrorCode::kUsage);
  EXPECT_EQ(reader.read_blob(store.color, {}, out).error().code, ErrorCode::kUsage);
  EXPECT_EQ(reader.read_blob(store.blobs, tile_at(1, 0, 0), out).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_region(reader, store.blobs, {0}, {0, 0, 4, 4}, out).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace vt::store
