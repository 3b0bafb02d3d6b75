#include "store/io/mapping.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

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
using testing::HasSubstr;

std::uint64_t sum_of(std::span<const std::byte> bytes) {
  std::uint64_t sum = 0;
  for (const std::byte byte : bytes) sum += std::to_integer<std::uint64_t>(byte);
  return sum;
}

struct MappingTest : testing::Test {
  MappingTest() { guard_mappings(); }

  Mapping map(const std::string& name, std::size_t bytes) {
    write_file(folder / name, Bytes(bytes, std::byte{7}));
    const File file = value_of(File::open(folder / name, File::Mode::kRead));
    return value_of(Mapping::map(file, bytes));
  }
  TempFolder folder;
};

TEST_F(MappingTest, TurnsToZerosWhenItsFileIsCutOff) {
  const Mapping other = map("other", 50000);
  for (const std::size_t left : {std::size_t{0}, std::size_t{1}, std::size_t{4096}, std::size_t{9000}}) {
    const Mapping mapping = map("a", 100000);
    EXPECT_EQ(sum_of(mapping.bytes()), 700000U);
    EXPECT_FALSE(mapping.is_lost());
    std::filesystem::resize_file(folder / "a", left);
    EXPECT_EQ(mapping.bytes()[99999], std::byte{0});
    EXPECT_TRUE(mapping.is_lost());
    EXPECT_EQ(sum_of(mapping.bytes()), 0U);
    std::filesystem::resize_file(folder / "a", 100000);
    EXPECT_EQ(sum_of(mapping.bytes()), 0U) << "for good";
  }
  EXPECT_EQ(sum_of(other.bytes()), 350000U);
  EXPECT_FALSE(other.is_lost());
}

TEST_F(MappingTest, HasZerosBehindTheFile) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{4095}, std::size_t{4096}, std::size_t{70000}}) {
    const Mapping mapping = map("a", size);
    EXPECT_EQ(sum_of({mapping.bytes().data(), size + Mapping::kSlack}), 7 * size);
  }
}

TEST_F(MappingTest, ManyThreadsMayLoseTheSameOne) {
  for (int round = 0; round < 20; ++round) {
    const Mapping mapping = map("a", 1 << 20);
    std::filesystem::resize_file(folder / "a", 0);
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) threads.emplace_back([&] { EXPECT_EQ(sum_of(mapping.bytes()), 0U); });
    threads.clear();
    EXPECT_TRUE(mapping.is_lost());
  }
}

// A fault outside every Mapping, in a file that is shorter than what was mapped of it.
[[noreturn]] void touch_what_is_not_there(const std::filesystem::path& path) {
  const int fd = open(path.c_str(), O_RDONLY);
  const auto* bytes = static_cast<const volatile std::byte*>(mmap(nullptr, 8192, PROT_READ, MAP_SHARED, fd, 0));
  _exit(bytes[4096] == std::byte{0} ? 3 : 4);
}

TEST(MappingDeathTest, OtherFaultsGoToTheHandlerThatWasThere) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a process of its own, without the guard
  const TempFolder folder;
  write_file(folder / "a", Bytes(4096));
  EXPECT_EXIT(
      {
        struct sigaction action = {};
        action.sa_handler = [](int) { _exit(7); };
        sigaction(SIGBUS, &action, nullptr);
        guard_mappings();
        touch_what_is_not_there(folder / "a");
      },
      testing::ExitedWithCode(7), "");
}

TEST(MappingDeathTest, OtherFaultsEndTheProcessWhereNoHandlerWas) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const TempFolder folder;
  write_file(folder / "a", Bytes(4096));
  EXPECT_EXIT(
      {
        std::signal(SIGBUS, SIG_DFL);
        guard_mappings();
        touch_what_is_not_there(folder / "a");
      },
      testing::KilledBySignal(SIGBUS), "");
}

// ---- A store whose file another program cuts off or overwrites ----

struct CutStore : testing::Test {
  CutStore() { guard_mappings(); }

  LayerInfo layer = small_layer("color", TexelFormat::kRgb8, 4, 7);
  std::vector<TileId> tiles;
  TempFolder folder;
  std::filesystem::path path = folder / "a.vts";

  void build(const std::filesystem::path& where, int version, bool is_compressed) {
    StoreWriter writer = value_of(StoreWriter::create(where, {}, {.sync = false}));
    const LayerId id = value_of(writer.add_layer(layer));
    tiles.clear();
    for (const int level : {0, 3, 7})
      for (std::uint32_t x = 0; x < 1U << level; ++x)
        for (const std::uint32_t y : {x % 5, 40 + x % 3, 90U})
          if (y < 1U << level) tiles.push_back(tile_at(level, x, y));
    for (const TileId tile : tiles)
      succeed(writer.put(id, tile, encoded(tile_bytes(layer, tile, version), {is_compressed ? Codec::kZstd : Codec::kRaw, 1})));
    succeed(writer.finish());
  }
  // Every tile is right or an error of the disk; gives the number of errors.
  std::size_t errors_reading(const StoreReader& reader) {
    std::size_t errors = 0;
    Bytes out(layer.tile_payload_bytes());
    for (const TileId tile : tiles) {
      const auto read = reader.read(LayerId{0}, tile, out);
      if (read) {
        EXPECT_EQ(out, tile_bytes(layer, tile));
        continue;
      }
      ++errors;
      EXPECT_EQ(read.error().code, ErrorCode::kIo) << read.error().message;
      EXPECT_THAT(read.error().message, HasSubstr("a.vts: was cut off or overwritten by another program"));
    }
    return errors;
  }
};

TEST_F(CutStore, EndsInAnErrorThatNamesTheFile) {
  for (const bool is_compressed : {false, true}) {
    for (const bool is_warm : {false, true}) {
      for (const double part : {0.0, 0.1, 0.5, 0.9, 0.999}) {
        build(path, 0, is_compressed);
        const StoreReader reader = value_of(StoreReader::open(path));
        succeed(reader.check_intact());
        if (is_warm) {
          ASSERT_EQ(errors_reading(reader), 0U);
        }
        std::filesystem::resize_file(path, static_cast<std::uintmax_t>(part * static_cast<double>(std::filesystem::file_size(path))));
        const std::size_t errors = errors_reading(reader);
        // At the very end lies the catalog, which was read when the store was opened.
        if (part <= 0.9) {
          EXPECT_GT(errors, 0U) << part;
        }
        EXPECT_EQ(reader.check_intact().error().code, ErrorCode::kIo);
        const auto lookup = reader.lookup(LayerId{0}, tile_at(7, 1, 1));
        if (part == 0.0) {
          EXPECT_FALSE(lookup) << "an index that is gone does not say \"absent\"";
        }
        std::filesystem::remove(path);
      }
    }
  }
}

TEST_F(CutStore, LookUpsOfAWarmIndexNoticeToo) {
  build(path, 0, false);
  const StoreReader reader = value_of(StoreReader::open(path));
  ASSERT_EQ(errors_reading(reader), 0U);
  std::vector<TileLookup> found(tiles.size());
  succeed(reader.lookup_many(LayerId{0}, tiles, found));
  std::filesystem::resize_file(path, 0);
  EXPECT_EQ(reader.lookup_many(LayerId{0}, tiles, found).error().code, ErrorCode::kIo);
  for (const TileId tile : tiles) EXPECT_EQ(reader.lookup(LayerId{0}, tile).error().code, ErrorCode::kIo);
  EXPECT_EQ(reader.nearest_present(LayerId{0}, tiles.back()).error().code, ErrorCode::kIo);
}

// The other store has the same tiles at the same places, each with a right checksum.
TEST_F(CutStore, NeverGivesTheTilesOfTheStoreThatOverwroteIt) {
  for (const bool is_warm : {false, true}) {
    build(path, 0, false);
    build(folder / "b.vts", 1, false);
    const Bytes other = read_file(folder / "b.vts");
    const StoreReader reader = value_of(StoreReader::open(path));
    if (is_warm) {
      ASSERT_EQ(errors_reading(reader), 0U);
    }
    ASSERT_EQ(other.size(), std::filesystem::file_size(path));
    write_file(path, other);  // into the same file, as cp does
    EXPECT_EQ(errors_reading(reader), tiles.size());
    std::filesystem::remove(path);
    std::filesystem::remove(folder / "b.vts");
  }
}

// Pages that were checked turn into anything.
TEST_F(CutStore, NoiseOverItIsAnErrorAndNoCrash) {
  std::mt19937 random(4);
  for (int round = 0; round < 30; ++round) {
    build(path, 0, round % 2 == 0);
    const StoreReader reader = value_of(StoreReader::open(path));
    ASSERT_EQ(errors_reading(reader), 0U);
    Bytes noise = read_file(path);
    for (std::size_t at = round % 3 == 0 ? 0 : kLogStart; at < noise.size(); ++at) noise[at] = static_cast<std::byte>(random());
    write_file(path, noise);
    Bytes out(layer.tile_payload_bytes());
    for (const TileId tile : tiles) {
      const auto read = reader.read(LayerId{0}, tile, out);
      EXPECT_TRUE(!read || out == tile_bytes(layer, tile));
      static_cast<void>(reader.lookup(LayerId{0}, tile));
    }
    std::filesystem::remove(path);
  }
}

TEST_F(CutStore, AValidatorSaysThatItCannotSayAnything) {
  build(path, 0, true);
  // Cut off when the first tiles have been looked at.
  const auto report = validate(path, {.progress = [&](std::uint64_t, std::uint64_t) { std::filesystem::resize_file(path, 9000); }});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::kIo);
  EXPECT_THAT(report.error().message, HasSubstr("a.vts: was cut off"));
}

}  // namespace
}  // namespace vt::store
