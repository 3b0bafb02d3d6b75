// The two superblocks: every commit is in both, so one of them is enough; what an older program has written
// is never taken for newer than it is, and never cut off.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "store/format/layout.h"
#include "store/pack.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;

const std::filesystem::path kGoldens = std::filesystem::path(VT_SOURCE_DIR) / "tests/golden";

ChosenSuperblock head_of(const std::filesystem::path& path) {
  const Bytes bytes = read_file(path);
  return choose_superblock(std::span(bytes).first(kLogStart), bytes.size()).value();
}

void spoil(const std::filesystem::path& path, std::uint64_t slot, std::size_t at = 50) {
  Bytes bytes = read_file(path);
  bytes[superblock_offset(slot) + at] ^= std::byte{1};
  write_file(path, bytes);
}

std::vector<int> errors_in(const std::filesystem::path& path) {
  std::vector<int> numbers;
  for (const Finding& finding : value_of(validate(path)).findings)
    if (finding.is_error) numbers.push_back(finding.number);
  return numbers;
}

struct SuperblockTest : testing::Test {
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";
  LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 2, 2);

  // One tile, changed by each of `commits`.
  void build(int commits) {
    StoreWriter writer = value_of(StoreWriter::create(path, {}));
    const LayerId id = value_of(writer.add_layer(layer));
    for (int version = 1; version <= commits; ++version) {
      succeed(writer.put(id, tile_at(0, 0, 0), encoded(tile_bytes(layer, tile_at(0, 0, 0), version))));
      succeed(writer.commit());
    }
    succeed(writer.finish());
  }
  void expect_version(int version) {
    const StoreReader reader = value_of(StoreReader::open(path));
    Bytes out(layer.tile_payload_bytes());
    succeed(reader.read(LayerId{0}, tile_at(0, 0, 0), out));
    EXPECT_EQ(out, tile_bytes(layer, tile_at(0, 0, 0), version));
  }
  // A store of one superblock a commit: the newest generation has a layer of one tile, the one before it has
  // none.
  void take_unpaired_store() { std::filesystem::copy_file(kGoldens / "version-3-unpaired.vts", path); }
};

TEST_F(SuperblockTest, EveryCommitIsInBoth) {
  for (const int commits : {1, 2, 3}) {
    std::filesystem::remove(path);
    build(commits);
    EXPECT_TRUE(head_of(path).is_pair());
    const Bytes whole = read_file(path);
    for (const std::uint64_t slot : {0, 1}) {
      for (const std::size_t at : {0, 8, 20, 32, 40, 60, 70, 85, 100, 2000, 4095}) {
        write_file(path, whole);
        spoil(path, slot, at);
        EXPECT_EQ(value_of(StoreReader::open(path)).health(), StoreHealth::kOneSuperblock);
        expect_version(commits);
      }
    }
  }
}

TEST_F(SuperblockTest, TheNextWriterMendsADamagedOneAtOnce) {
  build(2);
  for (const std::uint64_t slot : {0, 1, 0}) {
    spoil(path, slot);
    EXPECT_THAT(value_of(StoreReader::open(path)).health_remark(),
                AllOf(HasSubstr(slot == 0 ? "superblock A" : "superblock B"), HasSubstr("nothing is lost")));
    { const StoreWriter writer = value_of(StoreWriter::open(path)); }  // changes nothing
    EXPECT_TRUE(head_of(path).is_pair());
    EXPECT_EQ(value_of(StoreReader::open(path)).health(), StoreHealth::kWhole);
    EXPECT_EQ(value_of(StoreReader::open(path)).health_remark(), "");
    expect_version(2);
  }
}

TEST_F(SuperblockTest, AGenerationOnlyGrows) {
  build(1);
  std::uint64_t last = 0;
  for (int round = 0; round < 4; ++round) {
    StoreWriter writer = value_of(StoreWriter::open(path));
    succeed(writer.set_metadata(LayerId{0}, std::to_string(round)));
    succeed(writer.commit());
    const std::uint64_t now = value_of(StoreReader::open(path)).generation();
    EXPECT_EQ(now, writer.generation());
    EXPECT_GT(now, last);
    last = now;
  }
}

// Nobody knows whether the damaged one had been committed, so nobody acts as if he did.
TEST_F(SuperblockTest, ADamagedOneOfAnOlderProgramIsSaidAndNothingIsCutOff) {
  take_unpaired_store();
  ASSERT_EQ(head_of(path).newest.generation, 2U);
  spoil(path, 0);
  const Bytes damaged = read_file(path);

  const StoreReader reader = value_of(StoreReader::open(path));
  EXPECT_EQ(reader.health(), StoreHealth::kMayBeOlder);
  EXPECT_THAT(reader.health_remark(), AllOf(HasSubstr("superblock A"), HasSubstr("a generation after 1"), HasSubstr("may be older")));
  EXPECT_TRUE(reader.layers().empty());
  EXPECT_EQ(errors_in(path), std::vector<int>{110});

  const auto writer = StoreWriter::open(path);
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(writer.error().message, AllOf(HasSubstr("a.vts: not opened for writing"), HasSubstr("a later generation would be lost")));
  const auto packed = pack_in_place(path);
  ASSERT_FALSE(packed);
  EXPECT_EQ(packed.error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(read_file(path), damaged);

  // What is there can be taken along, by whoever decides so.
  ASSERT_TRUE(pack(reader, folder / "b.vts"));
  EXPECT_EQ(value_of(StoreReader::open(folder / "b.vts")).health(), StoreHealth::kWhole);
}

// Whatever its bytes say: programs of version 3 go on with such a store without keeping the pair.
TEST_F(SuperblockTest, NoStoreOfAnOlderVersionIsTakenForAPair) {
  std::filesystem::copy_file(kGoldens / "version-3-rich.vts", path);
  const std::uint64_t newest = head_of(path).newest.generation;
  Bytes bytes = read_file(path);
  bytes.resize(bytes.size() + 64);
  write_file(path, bytes);
  spoil(path, newest & 1);
  EXPECT_EQ(value_of(StoreReader::open(path)).health(), StoreHealth::kMayBeOlder);
  EXPECT_EQ(StoreWriter::open(path).error().code, ErrorCode::kCorrupt);
}

TEST_F(SuperblockTest, ADamagedOlderOneOfAnOlderProgramLosesNothing) {
  take_unpaired_store();
  const Contents truth = read_all(value_of(StoreReader::open(path)));
  spoil(path, 1);
  EXPECT_EQ(value_of(StoreReader::open(path)).health(), StoreHealth::kOneSuperblock) << "the log ends with the newest generation";
  EXPECT_TRUE(errors_in(path).empty());
  succeed(value_of(StoreWriter::open(path)).finish());
  EXPECT_TRUE(head_of(path).is_pair());
  EXPECT_EQ(read_all(value_of(StoreReader::open(path))), truth);
}

TEST_F(SuperblockTest, AStoreOfAnOlderProgramBecomesAPairBeforeItIsWrittenTo) {
  take_unpaired_store();
  const Contents truth = read_all(value_of(StoreReader::open(path)));
  // A crash inside the first superblock that is written leaves the other whole, and no tail that could be
  // mistaken for a commit.
  for (std::size_t refuse_at = 0;; ++refuse_at) {
    ASSERT_LT(refuse_at, 10U);
    std::size_t count = 0;
    const auto writer = StoreWriter::open(path, {.before_operation = [&](const FileOperation&) { return count++ == refuse_at ? EIO : 0; }});
    EXPECT_EQ(read_all(value_of(StoreReader::open(path))), truth);
    EXPECT_EQ(value_of(StoreReader::open(path)).health(), StoreHealth::kWhole);
    if (writer) break;
  }
  EXPECT_TRUE(head_of(path).is_pair());
  for (const std::uint64_t slot : {0, 1}) {
    const Bytes whole = read_file(path);
    spoil(path, slot);
    EXPECT_EQ(read_all(value_of(StoreReader::open(path))), truth);
    write_file(path, whole);
  }
}

TEST_F(SuperblockTest, AGenerationThatCannotBeFollowedIsNotWrittenTo) {
  build(1);
  Bytes bytes = read_file(path);
  for (const std::uint64_t slot : {0, 1}) {
    const auto block = std::span(bytes).subspan(superblock_offset(slot), kSuperblockBytes);
    put<std::uint64_t>(block, 32, ~std::uint64_t{1} + slot);
    put<std::uint64_t>(block, kSuperblockBytes - 8, hash_bytes(block.first(kSuperblockBytes - 8)));
  }
  write_file(path, bytes);
  expect_version(1);
  const auto writer = StoreWriter::open(path);
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().code, ErrorCode::kInvalidData);
  EXPECT_EQ(read_file(path), bytes);
}

// Whoever opens or validates beside a writer sees one whole state or another.
TEST_F(SuperblockTest, ReadersBesideABusyWriterSeeNothingWrong) {
  build(1);
  std::jthread writing([&](const std::stop_token& stop) {
    StoreWriter writer = value_of(StoreWriter::open(path, {.sync = false}));
    for (int version = 2; !stop.stop_requested(); ++version) {
      succeed(writer.put(LayerId{0}, tile_at(0, 0, 0), encoded(tile_bytes(layer, tile_at(0, 0, 0), version))));
      succeed(writer.set_metadata(LayerId{0}, std::string(static_cast<std::size_t>(version % 50), ' ')));
      succeed(writer.commit());
    }
  });
  std::uint64_t last = 0;
  Bytes out(layer.tile_payload_bytes());
  for (int round = 0; round < 400; ++round) {
    const auto report = value_of(validate(path));
    for (const Finding& finding : report.findings) ASSERT_FALSE(finding.is_error) << finding.number << " " << finding.sentence;
    const auto reader = StoreReader::open(path);
    ASSERT_TRUE(reader) << reader.error().message;
    ASSERT_GE(reader->generation(), last);
    last = reader->generation();
    ASSERT_TRUE(reader->read(LayerId{0}, tile_at(0, 0, 0), out));
  }
}

}  // namespace
}  // namespace vt::store
