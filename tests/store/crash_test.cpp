// Crashes at every moment: replays of the writer's own log of writes, full disks, killed processes. What was
// committed is there, whole, and nothing else.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <random>
#include <thread>

#include "store/format/layout.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "store/validate.h"
#include "tests/store/store_support.h"

namespace vt::store {
namespace {

using namespace test;
using Operation = FileOperation;

struct LoggedOperation {
  Operation::Kind kind;
  std::uint64_t offset;
  Bytes bytes;
};

const LayerInfo& test_layer() {
  static const LayerInfo layer = small_layer("l", TexelFormat::kRgb8, 2, 6);
  return layer;
}

// What commit number `version` changes; the state of the store at any generation follows from these alone.
struct Change {
  TileId tile;
  enum class Act { kPut, kConstant, kRemove } act;
};
std::vector<Change> changes_of(std::uint64_t version) {
  std::vector<Change> changes;
  std::mt19937_64 random(version);
  for (int i = 0; i < 5; ++i) {
    const int level = static_cast<int>(random() % 7);
    const TileId tile = tile_at(level, static_cast<std::uint32_t>(random() & ((1U << level) - 1)),
                                static_cast<std::uint32_t>(random() & ((1U << level) - 1)));
    changes.push_back({tile, random() % 6 == 0 ? Change::Act::kRemove : random() % 3 == 0 ? Change::Act::kConstant : Change::Act::kPut});
  }
  return changes;
}
Bytes bytes_of(const Change& change, std::uint64_t version) {
  // Half of the columns repeat a few contents, so that records are shared.
  const bool is_repeated = change.tile.x % 2 == 0;
  Bytes bytes = tile_bytes(test_layer(), is_repeated ? TileId{} : change.tile, static_cast<int>(is_repeated ? version / 3 : version));
  if (change.act == Change::Act::kConstant)
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(version + i % 3);
  return bytes;
}
void apply(Contents& contents, std::uint64_t version) {
  for (const Change& change : changes_of(version)) {
    if (change.act == Change::Act::kRemove) {
      contents.erase({"l", change.tile});
    } else {
      contents[{"l", change.tile}] = bytes_of(change, version);
    }
  }
}
Result<void> apply(StoreWriter& writer, LayerId id, std::uint64_t version) {
  for (const Change& change : changes_of(version)) {
    const Bytes bytes = bytes_of(change, version);
    switch (change.act) {
      case Change::Act::kPut:
        VT_CHECK(writer.put(id, change.tile, encoded(bytes)));
        break;
      case Change::Act::kConstant:
        VT_CHECK(writer.put_constant(id, change.tile, std::span(bytes).first(3)));
        break;
      case Change::Act::kRemove:
        VT_CHECK(writer.remove(id, change.tile));
        break;
    }
  }
  return {};
}
// Version 1 is empty; version 2 has the layer; version v has the changes of 3..v. A commit always has
// something to write: the metadata names it.
Result<void> commit_version(StoreWriter& writer, LayerId id, std::uint64_t version) {
  VT_CHECK(apply(writer, id, version));
  VT_CHECK(writer.set_metadata(id, std::to_string(version)));
  return writer.commit();
}
Contents contents_at(std::uint64_t last) {
  Contents contents;
  for (std::uint64_t version = 3; version <= last; ++version) apply(contents, version);
  return contents;
}
// Every commit makes two generations of one state, the first one 0 and 1. A writer that mends the superblocks
// makes two more, so the metadata say the version, once there is a layer.
std::uint64_t version_in(std::span<const LayerInfo> layers) {
  if (layers.empty()) return 1;
  return layers[0].metadata_json.empty() ? 2 : std::stoull(layers[0].metadata_json);
}
std::uint64_t version_of(const StoreReader& reader) { return version_in(reader.layers()); }
std::uint64_t version_of(const StoreWriter& writer) { return version_in(writer.layers()); }

// The file opens at a whole version within [at_least, at_most], validates, holds exactly that version's
// tiles, and can be written to again.
void expect_whole(const std::filesystem::path& path, std::uint64_t at_least, std::uint64_t at_most, const std::string& moment) {
  std::uint64_t version = 0;
  {
    const auto reader = StoreReader::open(path);
    ASSERT_TRUE(reader) << moment << ": " << reader.error().message;
    version = version_of(*reader);
    ASSERT_GE(version, at_least) << moment << ": a commit that had returned is lost";
    ASSERT_LE(version, at_most) << moment;
    ASSERT_NE(reader->health(), StoreHealth::kMayBeOlder) << moment << ": a torn commit is ordinary";
    ASSERT_EQ(read_all(*reader), contents_at(version)) << moment;
    const auto report = value_of(validate(path));
    for (const Finding& finding : report.findings)
      ASSERT_FALSE(finding.is_error) << moment << ": " << finding.number << " " << finding.sentence;
  }
  if (version < 2) return;
  StoreWriter writer = value_of(StoreWriter::open(path, {.sync = false}));
  succeed(commit_version(writer, LayerId{0}, version + 1));
  succeed(writer.finish());
  const StoreReader reader = value_of(StoreReader::open(path));
  ASSERT_EQ(read_all(reader), contents_at(version + 1)) << moment;
  ASSERT_EQ(reader.health(), StoreHealth::kWhole) << moment << ": a writer mends the superblocks";
}

TEST(Crash, EveryReplayOfTheWriteLogIsAWholeGeneration) {
  const TempFolder folder;
  std::vector<LoggedOperation> log;
  const WriterOptions recording{.before_operation = [&](const Operation& operation) {
    log.push_back({operation.kind, operation.offset, Bytes(operation.bytes.begin(), operation.bytes.end())});
    return 0;
  }};
  // For each moment (number of operations done): the commits that had returned by then.
  std::map<std::size_t, std::uint64_t> returned;
  {
    StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}, recording));
    returned[log.size()] = 1;
    const LayerId id = value_of(writer.add_layer(test_layer()));
    succeed(writer.commit());
    returned[log.size()] = 2;
    for (std::uint64_t version = 3; version <= 6; ++version) {
      succeed(commit_version(writer, id, version));
      returned[log.size()] = version;
    }
    // A session that ends without a commit leaves a tail for the next one to remove.
    succeed(apply(writer, id, 99));
  }
  {
    StoreWriter writer = value_of(StoreWriter::open(folder / "a.vts", recording));
    for (std::uint64_t version = 7; version <= 10; ++version) {
      succeed(commit_version(writer, LayerId{0}, version));
      returned[log.size()] = version;
    }
    succeed(writer.finish());
  }
  const std::size_t created = returned.begin()->first;  // before this the file has no name
  ASSERT_EQ(returned.rbegin()->second, 10U);
  ASSERT_EQ(read_all(value_of(StoreReader::open(folder / "a.vts"))), contents_at(10));

  const auto write_into = [](Bytes& file, std::uint64_t offset, std::span<const std::byte> bytes) {
    if (file.size() < offset + bytes.size()) file.resize(offset + bytes.size());
    std::copy(bytes.begin(), bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(offset));
  };
  const auto perform = [&](Bytes& file, const LoggedOperation& operation) {
    if (operation.kind == Operation::Kind::kWrite) write_into(file, operation.offset, operation.bytes);
    if (operation.kind == Operation::Kind::kTruncate) file.resize(operation.offset);
  };
  const auto check = [&](const Bytes& file, std::size_t done, const std::string& moment) {
    write_file(folder / "crashed.vts", file);
    const std::uint64_t at_least = std::prev(returned.upper_bound(done))->second;
    ASSERT_NO_FATAL_FAILURE(expect_whole(folder / "crashed.vts", at_least, at_least + 1, moment));
  };

  std::mt19937 random(21);
  Bytes synced;   // what certainly is on the disk
  Bytes written;  // what the operating system has been told
  std::size_t first_unsynced = 0;
  for (std::size_t done = 0; done <= log.size(); ++done) {
    if (done >= created) {
      // The process is killed here: everything it wrote is there.
      ASSERT_NO_FATAL_FAILURE(check(written, done, "after operation " + std::to_string(done)));
      // It is killed inside the next write.
      if (done < log.size() && log[done].kind == Operation::Kind::kWrite) {
        const Bytes& bytes = log[done].bytes;
        for (const std::size_t part : {std::size_t{1}, bytes.size() / 2, bytes.size() - 1}) {
          Bytes torn = written;
          write_into(torn, log[done].offset, std::span(bytes).first(part));
          ASSERT_NO_FATAL_FAILURE(check(torn, done, "inside operation " + std::to_string(done) + ", " + std::to_string(part) + " bytes"));
        }
      }
      // The power fails here: of what was written since the last sync, any sectors may have reached the disk,
      // in any order.
      for (int trial = 0; trial < 6; ++trial) {
        Bytes disk = synced;
        for (std::size_t i = first_unsynced; i < done; ++i) {
          if (log[i].kind == Operation::Kind::kTruncate && random() % 2 == 0) perform(disk, log[i]);
          if (log[i].kind != Operation::Kind::kWrite) continue;
          constexpr std::size_t kSector = 512;
          for (std::size_t at = 0; at < log[i].bytes.size(); at += kSector) {
            if (random() % 2 == 0) continue;
            write_into(disk, log[i].offset + at, std::span(log[i].bytes).subspan(at, std::min(kSector, log[i].bytes.size() - at)));
          }
        }
        ASSERT_NO_FATAL_FAILURE(
            check(disk, done, "power cut after operation " + std::to_string(done) + ", trial " + std::to_string(trial)));
      }
    }
    if (done == log.size()) break;
    perform(written, log[done]);
    if (log[done].kind == Operation::Kind::kSync) {
      synced = written;
      first_unsynced = done + 1;
    }
  }
}

// Both a disk that is full from some moment on and one that refuses a single operation.
TEST(Crash, AFullDiskAtAnyWriteLeavesTheLastCommit) {
  for (const bool for_good : {true, false}) {
    for (std::size_t refuse_at = 0;; ++refuse_at) {
      const TempFolder folder;
      const auto path = folder / "a.vts";
      std::size_t count = 0;
      const WriterOptions options{.before_operation =
                                      [&](const Operation&) {
                                        const std::size_t number = count++;
                                        return (for_good ? number >= refuse_at : number == refuse_at) ? ENOSPC : 0;
                                      },
                                  .sync = true};
      std::uint64_t committed = 0;
      const auto session = [&]() -> Result<void> {
        VT_ASSIGN(StoreWriter writer, StoreWriter::create(path, {}, options));
        committed = 1;
        VT_ASSIGN(const LayerId id, writer.add_layer(test_layer()));
        VT_CHECK(writer.commit());
        committed = 2;
        for (std::uint64_t version = 3; version <= 5; ++version) {
          if (auto done = commit_version(writer, id, version); !done) {
            // From the first failure on every change is refused with the same sentence; what was there can
            // still be read.
            const auto again = writer.commit();
            EXPECT_FALSE(again);
            EXPECT_EQ(again.error().message, done.error().message);
            EXPECT_FALSE(writer.put_constant(id, tile_at(0, 0, 0), Bytes(3)));
            for (const auto& [name, bytes] : contents_at(committed)) {
              Bytes out(bytes.size());
              if (writer.contains(id, name.second)) {
                EXPECT_TRUE(writer.read(id, name.second, out));
              }
            }
            return done;
          }
          committed = version;
        }
        return writer.finish();
      };
      const auto outcome = session();
      if (outcome) {
        EXPECT_GT(refuse_at, 20U);
        break;
      }
      EXPECT_EQ(outcome.error().code, ErrorCode::kIo);
      EXPECT_THAT(outcome.error().message, testing::HasSubstr("No space left on device"));
      if (committed == 0) {  // nothing is left behind, not even half a file
        EXPECT_TRUE(std::filesystem::is_empty(path.parent_path()));
        continue;
      }
      // When the new state is in one superblock and not yet in the other, it may be there already: whole,
      // too.
      ASSERT_NO_FATAL_FAILURE(expect_whole(path, committed, committed + 1, "refused at " + std::to_string(refuse_at)));
    }
  }
}

// Every round waits until its writer has committed, however busy the machine is, and ends it at some moment
// after that.
TEST(Crash, AKilledWriterNeverLosesACommitNorShowsHalfOfOne) {
  constexpr int kKills = 240;
  const TempFolder folder;
  const auto path = folder / "a.vts";
  {
    StoreWriter writer = value_of(StoreWriter::create(path, {}));
    ASSERT_TRUE(writer.add_layer(test_layer()));
    succeed(writer.finish());
  }
  std::mt19937 random(33);
  std::uint64_t version = 2;
  Contents truth;
  for (int kill_number = 0; kill_number < kKills; ++kill_number) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      close(pipe_ends[0]);
      // A kill does not lose what the kernel was told, so most rounds need no slow syncs; a few keep them.
      auto writer = StoreWriter::open(path, {.sync = kill_number % 48 == 0});
      if (!writer) _exit(3);
      for (std::uint64_t next = version_of(*writer) + 1;; ++next) {
        if (!commit_version(*writer, LayerId{0}, next)) _exit(4);
        if (write(pipe_ends[1], &next, sizeof next) != sizeof next) _exit(5);
      }
    }
    close(pipe_ends[1]);
    std::uint64_t reported = 0;
    std::uint64_t one = 0;
    if (read(pipe_ends[0], &one, sizeof one) == sizeof one) reported = one;
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself, with " << WEXITSTATUS(status);
    while (read(pipe_ends[0], &one, sizeof one) == sizeof one) reported = one;
    close(pipe_ends[0]);
    ASSERT_GT(reported, version) << "a commit a round at least";

    const StoreReader reader = value_of(StoreReader::open(path));
    ASSERT_GE(version_of(reader), reported);
    ASSERT_LE(version_of(reader), reported + 1);
    while (version < version_of(reader)) apply(truth, ++version);
    ASSERT_EQ(read_all(reader), truth);
    const auto report = value_of(validate(path));
    for (const Finding& finding : report.findings) ASSERT_FALSE(finding.is_error) << finding.number << " " << finding.sentence;
  }
}

TEST(Threads, ManyThreadsPutReadAndAskAtOnce) {
  const TempFolder folder;
  StoreWriter writer = value_of(StoreWriter::create(folder / "a.vts", {}, {.sync = false}));
  const LayerInfo layer = small_layer("l", TexelFormat::kRgba8, 3, 7);
  const LayerId id = value_of(writer.add_layer(layer));
  constexpr std::uint32_t kThreads = 4;
  for (int round = 0; round < 3; ++round) {
    std::vector<std::jthread> threads;
    for (std::uint32_t t = 0; t < kThreads; ++t) {
      threads.emplace_back([&, t] {
        Bytes out(layer.tile_payload_bytes());
        for (std::uint32_t i = 0; i < 300; ++i) {
          const TileId tile = tile_at(7, (i * 13 + static_cast<std::uint32_t>(round) * 5) % 128, t * 32 + i % 32);
          EXPECT_TRUE(writer.put(id, tile, encoded(tile_bytes(layer, tile), {Codec::kZstd, 1})));
          EXPECT_TRUE(writer.contains(id, tile));
          EXPECT_TRUE(writer.read(id, tile, out));
          EXPECT_EQ(out, tile_bytes(layer, tile));
          // All threads fight over these.
          const TileId shared = tile_at(3, i % 8, 0);
          if (i % 3 == 0) {
            EXPECT_TRUE(writer.put_constant(id, shared, Bytes(4, static_cast<std::byte>(i))));
          } else {
            EXPECT_TRUE(writer.put(id, shared, encoded(tile_bytes(layer, shared))));
          }
          EXPECT_TRUE(writer.put(id, tile_at(6, i % 64, t), encoded(tile_bytes(layer, tile_at(6, i % 4, 0)))));
          EXPECT_TRUE(writer.read(id, shared, out));
          if (i % 50 == 0) {
            EXPECT_TRUE(writer.remove(id, tile_at(5, t, i % 32)));
          }
        }
      });
    }
    threads.clear();
    succeed(writer.commit());
  }
  succeed(writer.finish());
  EXPECT_TRUE(value_of(validate(folder / "a.vts")).ok());

  // A fresh reader whose pages are verified by many threads at once.
  const StoreReader reader = value_of(StoreReader::open(folder / "a.vts"));
  std::vector<std::jthread> threads;
  for (std::uint32_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      Bytes out(layer.tile_payload_bytes());
      std::mt19937 random(t);
      for (int i = 0; i < 2000; ++i) {
        const TileId tile = tile_at(7, random() % 128, random() % 128);
        const auto lookup = reader.lookup(id, tile);
        ASSERT_TRUE(lookup);
        if (lookup->kind == TileKind::kAbsent) continue;
        ASSERT_TRUE(reader.read(id, tile, out));
        EXPECT_EQ(out, tile_bytes(layer, tile));
      }
    });
  }
}

}  // namespace
}  // namespace vt::store
