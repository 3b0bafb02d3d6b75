// Tiles of equal payloads share one record, and only those.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <set>
#include <thread>

#include "store/format/layout.h"
#include "store/index/known_payloads.h"
#include "store/pack.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;

// Content number `number` of a layer.
Bytes content(const LayerInfo& layer, int number) { return tile_bytes(layer, {}, number); }

class SharedTiles : public testing::Test {
 protected:
  void create(WriterOptions options = {}) {
    options.sync = false;
    writer_.emplace(value_of(StoreWriter::create(path_, {}, std::move(options))));
    id_ = value_of(writer_->add_layer(layer_));
  }
  void put(TileId tile, int number, Compression compression = {}) {
    truth_[{layer_.name, tile}] = content(layer_, number);
    succeed(writer_->put(id_, tile, encoded(truth_[{layer_.name, tile}], compression)));
  }
  // Closes the writer, and holds the store against what was put.
  StoreReader finished() {
    succeed(writer_->finish());
    writer_.reset();
    StoreReader reader = value_of(StoreReader::open(path_));
    EXPECT_EQ(read_all(reader), truth_);
    const auto report = value_of(validate(path_));
    for (const Finding& finding : report.findings) EXPECT_FALSE(finding.is_error) << finding.number << " " << finding.sentence;
    return reader;
  }
  std::uint64_t record_of(const StoreReader& reader, TileId tile) const { return value_of(reader.lookup(id_, tile)).offset; }

  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "a.vts";
  LayerInfo layer_ = small_layer("l", TexelFormat::kRgb8, 3, 9);
  std::optional<StoreWriter> writer_;
  LayerId id_;
  Contents truth_;
};

TEST_F(SharedTiles, EqualTilesHaveOneRecordAndOthersTheirOwn) {
  create();
  for (std::uint32_t x = 0; x < 8; ++x) put(tile_at(3, x, 0), x < 5 ? 77 : static_cast<int>(x));
  const StoreReader reader = finished();
  std::set<std::uint64_t> records;
  for (std::uint32_t x = 0; x < 8; ++x) records.insert(record_of(reader, tile_at(3, x, 0)));
  EXPECT_EQ(records.size(), 4U);
  for (std::uint32_t x = 1; x < 5; ++x) EXPECT_EQ(record_of(reader, tile_at(3, x, 0)), record_of(reader, tile_at(3, 0, 0))) << x;
  const LayerInfo& info = *reader.find_layer("l");
  EXPECT_EQ(info.tiles, 8U);
  EXPECT_EQ(info.constant_tiles, 0U);
  EXPECT_EQ(info.stored_bytes, 8 * aligned(kRecordHeaderBytes + info.tile_payload_bytes()));
}

TEST_F(SharedTiles, CompressedPayloadsShareToo) {
  create();
  for (std::uint32_t x = 0; x < 4; ++x) put(tile_at(3, x, 0), 1, {Codec::kZstd, 3});
  const StoreReader reader = finished();
  EXPECT_EQ(value_of(reader.lookup(id_, tile_at(3, 0, 0))).codec, Codec::kZstd);
  EXPECT_EQ(record_of(reader, tile_at(3, 3, 0)), record_of(reader, tile_at(3, 0, 0)));
}

TEST_F(SharedTiles, ALaterChangeOfOneLeavesTheOthersAlone) {
  create();
  for (std::uint32_t x = 0; x < 4; ++x) put(tile_at(3, x, 0), 1);
  put(tile_at(3, 1, 0), 2);
  succeed(writer_->remove(id_, tile_at(3, 2, 0)));
  truth_.erase({"l", tile_at(3, 2, 0)});
  succeed(writer_->commit());
  put(tile_at(3, 0, 0), 2);
  const StoreReader reader = finished();
  EXPECT_EQ(record_of(reader, tile_at(3, 1, 0)), record_of(reader, tile_at(3, 0, 0)));
}

// The first tile may have become something else before its equal came.
TEST_F(SharedTiles, TheFirstIsPointedElsewhereOnlyWhileItIsWhatItWas) {
  create();
  put(tile_at(3, 0, 0), 1);
  put(tile_at(3, 0, 0), 2);
  put(tile_at(3, 1, 0), 1);
  put(tile_at(3, 2, 0), 3);
  succeed(writer_->remove(id_, tile_at(3, 2, 0)));
  truth_.erase({"l", tile_at(3, 2, 0)});
  put(tile_at(3, 3, 0), 3);
  // Its layer may be gone, or another have its number.
  const LayerInfo other = small_layer("other", TexelFormat::kRgb8, 3, 0);
  const LayerId gone = value_of(writer_->add_layer(other));
  succeed(writer_->put(gone, {}, encoded(content(layer_, 4))));
  succeed(writer_->remove_layer(gone));
  put(tile_at(3, 4, 0), 4);
  finished();
}

TEST_F(SharedTiles, PuttingATileAgainWritesNothing) {
  create();
  put(tile_at(3, 0, 0), 1);
  succeed(writer_->commit());
  const std::uint64_t bytes = writer_->file_bytes();
  const std::uint64_t generation = writer_->generation();
  put(tile_at(3, 0, 0), 1);
  succeed(writer_->commit());
  EXPECT_EQ(writer_->file_bytes(), bytes);
  EXPECT_EQ(writer_->generation(), generation);
  // There and back: the old record is as good as a new one.
  put(tile_at(3, 0, 0), 2);
  put(tile_at(3, 0, 0), 1);
  finished();
}

// The same bytes may be texels of two formats; each layer reads them as its own.
TEST_F(SharedTiles, LayersOfOneTileSizeShare) {
  create();
  const LayerInfo bytes = small_layer("bytes", TexelFormat::kRgba8, 3, 1);
  const LayerInfo floats = small_layer("floats", TexelFormat::kR32Float, 3, 1);
  const LayerInfo large = small_layer("large", TexelFormat::kRgba32Float, 2, 1);  // as many bytes, in fewer texels
  const Bytes texels = content(bytes, 1);
  for (const LayerInfo& layer : {bytes, floats, large}) {
    const LayerId id = value_of(writer_->add_layer(layer));
    succeed(writer_->put(id, {}, encoded(texels)));
    truth_[{layer.name, TileId{}}] = texels;
  }
  const StoreReader reader = finished();
  const std::uint64_t first = value_of(reader.lookup(reader.find_layer("bytes")->id, {})).offset;
  EXPECT_EQ(value_of(reader.lookup(reader.find_layer("floats")->id, {})).offset, first);
  EXPECT_EQ(value_of(reader.lookup(reader.find_layer("large")->id, {})).offset, first);
}

// Whatever the hash says, bytes decide: here all payloads have one fingerprint.
TEST_F(SharedTiles, CollidingHashesMixNothingUp) {
  create({.payload_fingerprint = [](const PayloadView&) { return std::uint64_t{42}; }});
  for (std::uint32_t i = 0; i < 64; ++i)
    put(tile_at(3, i % 8, i / 8), static_cast<int>(i * 7 % 5), i % 3 == 0 ? Compression{} : Compression{Codec::kZstd, 1});
  // Twice the same in a row is still found.
  put(tile_at(4, 0, 0), 9);
  put(tile_at(4, 1, 0), 9);
  const StoreReader reader = finished();
  EXPECT_EQ(record_of(reader, tile_at(4, 1, 0)), record_of(reader, tile_at(4, 0, 0)));
}

TEST_F(SharedTiles, ThousandsOfPayloadsMayBeForgottenButNotConfused) {
  layer_ = small_layer("l", TexelFormat::kRgb8, 2, 9);
  create();
  constexpr std::uint32_t kSide = 512;
  for (std::uint32_t i = 0; i < 70000; ++i) {
    const TileId tile = tile_at(9, i % kSide, i / kSide);
    Bytes bytes(layer_.tile_payload_bytes());
    vt::store::put<std::uint32_t>(bytes, 20, i % 69000);  // the last thousand are those at the start
    truth_[{"l", tile}] = bytes;
    succeed(writer_->put(id_, tile, encoded(bytes)));
  }
  finished();
}

TEST_F(SharedTiles, TheWriterSeesWhatIsShared) {
  create();
  for (std::uint32_t x = 0; x < 3; ++x) put(tile_at(3, x, 0), 1);
  Bytes out(layer_.tile_payload_bytes());
  for (std::uint32_t x = 0; x < 3; ++x) {
    succeed(writer_->read(id_, tile_at(3, x, 0), out));
    EXPECT_EQ(out, content(layer_, 1));
    EXPECT_TRUE(value_of(writer_->holds(id_, tile_at(3, x, 0), encoded(content(layer_, 1)))));
    EXPECT_FALSE(value_of(writer_->holds(id_, tile_at(3, x, 0), encoded(content(layer_, 2)))));
  }
  finished();
}

TEST_F(SharedTiles, StaySharedInAPackedStore) {
  create();
  for (int level = 0; level < 3; ++level)
    for (std::uint32_t x = 0; x < 1U << level; ++x) put(tile_at(level, x, 0), 10 * level + static_cast<int>(x) + 20);
  for (std::uint32_t x = 0; x < 8; ++x) put(tile_at(3, x, 0), x < 6 ? 1 : static_cast<int>(x));
  succeed(writer_->set_state(id_, LayerState::kComplete));
  const StoreReader reader = finished();
  PackOptions options;
  options.writer.sync = false;
  ASSERT_TRUE(pack(reader, folder_ / "packed.vts", options));
  const StoreReader packed = value_of(StoreReader::open(folder_ / "packed.vts"));
  EXPECT_EQ(read_all(packed), truth_);
  std::set<std::uint64_t> records;
  for (std::uint32_t x = 0; x < 8; ++x) records.insert(record_of(packed, tile_at(3, x, 0)));
  EXPECT_EQ(records.size(), 3U);
}

// What was written in this session and is damaged already is no twin of anything.
TEST_F(SharedTiles, ADamagedTwinIsAnErrorAndNotShared) {
  create();
  put(tile_at(3, 0, 0), 1);
  const std::uint64_t end = writer_->file_bytes();
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(end - 64 - 1 - (aligned(kRecordHeaderBytes + 192) - kRecordHeaderBytes - 192)));
  file.put('\xFF').flush();
  const auto second = writer_->put(id_, tile_at(3, 1, 0), encoded(content(layer_, 1)));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kCorrupt);
  EXPECT_FALSE(writer_->contains(id_, tile_at(3, 1, 0)));
  // The next one does not find it again, and is written.
  EXPECT_TRUE(writer_->put(id_, tile_at(3, 1, 0), encoded(content(layer_, 1))));
}

// ---- Threads ----

// How many records there are follows from what was put, not from who came first.
TEST_F(SharedTiles, ManyThreadsShareAsOneWould) {
  std::set<std::uint64_t> file_sizes;
  for (const int threads : {1, 4, 4}) {
    std::filesystem::remove(path_);
    truth_.clear();
    create();
    constexpr std::uint32_t kTiles = 1024;
    for (std::uint32_t i = 0; i < kTiles; ++i) truth_[{"l", tile_at(5, i % 32, i / 32)}] = content(layer_, static_cast<int>(i % 100));
    std::atomic<std::uint32_t> next = 0;
    {
      std::vector<std::jthread> workers;
      for (int t = 0; t < threads; ++t) {
        workers.emplace_back([&] {
          for (std::uint32_t i = next++; i < kTiles; i = next++) {
            const TileId tile = tile_at(5, i % 32, i / 32);
            EXPECT_TRUE(writer_->put(id_, tile, encoded(truth_.at({"l", tile}))));
          }
        });
      }
    }
    const StoreReader reader = finished();
    file_sizes.insert(reader.file_bytes());
    std::set<std::uint64_t> records;
    for (const auto& [place, bytes] : truth_) records.insert(record_of(reader, place.second));
    EXPECT_EQ(records.size(), 100U);
  }
  EXPECT_EQ(file_sizes.size(), 1U);
}

TEST_F(SharedTiles, CommitsBesideThemLoseNothing) {
  create();
  std::atomic<bool> is_done = false;
  {
    std::vector<std::jthread> workers;
    for (std::uint32_t t = 0; t < 3; ++t) {
      workers.emplace_back([&, t] {
        for (std::uint32_t i = 0; i < 300; ++i)
          EXPECT_TRUE(writer_->put(id_, tile_at(6, i % 64, t), encoded(content(layer_, static_cast<int>((i * (t + 1)) % 7)))));
        if (t == 0) is_done = true;
      });
    }
    while (!is_done) succeed(writer_->commit());
  }
  for (std::uint32_t t = 0; t < 3; ++t)
    for (std::uint32_t i = 0; i < 300; ++i) truth_[{"l", tile_at(6, i % 64, t)}] = content(layer_, static_cast<int>((i * (t + 1)) % 7));
  finished();
}

// Those who wait for a payload are let go when its write fails.
TEST_F(SharedTiles, AFailedWriteLeavesNobodyWaiting) {
  std::atomic<bool> is_full = false;
  create({.before_operation = [&](const FileOperation&) { return is_full ? ENOSPC : 0; }});
  put(tile_at(3, 0, 0), 1);
  is_full = true;
  std::vector<std::jthread> workers;
  for (std::uint32_t t = 0; t < 4; ++t) {
    workers.emplace_back([&, t] {
      for (std::uint32_t i = 0; i < 8; ++i) {
        const auto refused = writer_->put(id_, tile_at(4, i, t), encoded(content(layer_, 2)));
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::kIo);
      }
    });
  }
}

TEST(PayloadFingerprint, SeesCodecSizeAndSamples) {
  Bytes bytes(5000);
  const PayloadView view(Codec::kRaw, 5000, bytes);
  const std::uint64_t fingerprint = payload_fingerprint(view);
  EXPECT_EQ(payload_fingerprint(PayloadView(Codec::kRaw, 5000, Bytes(5000))), fingerprint);
  EXPECT_NE(payload_fingerprint(PayloadView(Codec::kZstd, 5000, bytes)), fingerprint);
  EXPECT_NE(payload_fingerprint(PayloadView(Codec::kRaw, 5001, bytes)), fingerprint);
  EXPECT_NE(payload_fingerprint(PayloadView(Codec::kRaw, 5000, std::span(bytes).first(4999))), fingerprint);
  bytes.front() = std::byte{1};
  EXPECT_NE(payload_fingerprint(view), fingerprint);
  bytes.front() = std::byte{0};
  bytes.back() = std::byte{1};
  EXPECT_NE(payload_fingerprint(view), fingerprint);
  for (std::size_t size = 0; size < 600; ++size) {
    const Bytes exact(size, std::byte{7});  // so that the sanitizer sees a read past its end
    static_cast<void>(payload_fingerprint(PayloadView(Codec::kRaw, 600, exact)));
  }
}

}  // namespace
}  // namespace vt::store
