// Rows decoded once, whoever reads them in whatever order; disk space given back; a full disk said so;
// nothing left behind.
#include "builder/source/cells/spilled_rows.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <random>
#include <thread>

#include "tests/support/temp_folder.h"

namespace vt::source {
namespace {

using test::TempFolder;

// Every sample says where it is.
std::uint32_t sample_at(std::int64_t x, std::int64_t y, int plane) { return static_cast<std::uint32_t>(y * 100000 + x * 10 + plane); }

// Counts how often each cell was decoded, and how often a sequential decoder had to start over.
class CountingDecoder final : public CellDecoder {
 public:
  explicit CountingDecoder(const CellGrid& grid) : grid_(grid), decoded_(static_cast<std::size_t>(grid.cells_down())) {}
  const CellGrid& grid() const override { return grid_; }
  Result<Block> decode_cell(std::int64_t cell_x, std::int64_t cell_y, int plane) const override {
    EXPECT_EQ(cell_x, 0);
    if (cell_y == fails_at) return fail(ErrorCode::kCorrupt, "damaged on purpose");
    ++decoded_[static_cast<std::size_t>(cell_y)];
    if (grid_.is_sequential && cell_y % grid_.cells_per_block() != 0 && cell_y < next_) ++restarts_;
    next_ = cell_y + 1;
    Block block(static_cast<std::size_t>(grid_.cell_rows(cell_y) * grid_.row_bytes()));
    std::byte* out = block.data();
    for (std::int64_t y = 0; y < grid_.cell_rows(cell_y); ++y) {
      for (std::int64_t x = 0; x < grid_.width; ++x, out += 4) {
        const std::uint32_t value = sample_at(x, grid_.first_row(cell_y) + y, plane);
        std::memcpy(out, &value, 4);
      }
    }
    return block;
  }
  int decoded(std::int64_t cell) const { return decoded_[static_cast<std::size_t>(cell)]; }
  int restarts() const { return restarts_; }
  std::int64_t fails_at = -1;

 private:
  CellGrid grid_;
  mutable std::vector<std::atomic<int>> decoded_;
  mutable std::atomic<std::int64_t> next_ = 0;
  mutable std::atomic<int> restarts_ = 0;
};

CellGrid grid_of(bool sequential, std::int64_t block_height) {
  return {.width = 301,
          .height = 2000,
          .block_width = 301,
          .block_height = block_height,
          .rows_per_cell = sequential ? 7 : block_height,
          .stride = 4,
          .planes = 1,
          .is_sequential = sequential};
}

void expect_rows(SpilledRows& rows, const SpilledRows::Rect& rect) {
  std::vector<std::byte> out(static_cast<std::size_t>(rect.rows * rect.columns * 4));
  const auto read = rows.read(rect, out);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  const std::byte* at = out.data();
  for (std::int64_t y = rect.row; y < rect.row + rect.rows; ++y) {
    for (std::int64_t x = rect.column; x < rect.column + rect.columns; ++x, at += 4) {
      std::uint32_t value = 0;
      std::memcpy(&value, at, 4);
      ASSERT_EQ(value, sample_at(x, y, 0)) << x << "," << y;
    }
  }
}

TEST(SpilledRows, EveryCellIsDecodedOnceWhoeverReads) {
  const TempFolder folder;
  for (const bool sequential : {false, true}) {
    for (const std::int64_t block_height : {2000, 333, 5}) {
      if (!sequential && block_height == 2000) continue;  // one cell
      const CellGrid grid = grid_of(sequential, block_height);
      const CountingDecoder decoder(grid);
      SpilledRows rows(decoder, 0, std::make_shared<ScratchFile>(folder.path()));
      {
        std::vector<std::jthread> threads;
        for (std::uint32_t seed = 0; seed < 4; ++seed) {
          threads.emplace_back([&, seed] {
            std::mt19937 random(seed);
            const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint32_t>(n)); };
            for (int i = 0; i < 60; ++i) {
              SpilledRows::Rect rect{.row = below(2000), .rows = 0, .column = below(301), .columns = 0};
              rect.rows = 1 + below(std::min<std::int64_t>(50, 2000 - rect.row));
              rect.columns = 1 + below(301 - rect.column);
              expect_rows(rows, rect);
            }
            expect_rows(rows, {.row = 0, .rows = 2000, .column = 0, .columns = 301});
          });
        }
      }
      for (std::int64_t cell = 0; cell < grid.cells_down(); ++cell)
        EXPECT_EQ(decoder.decoded(cell), grid.cell_rows(cell) > 0 ? 1 : 0) << "cell " << cell;
      EXPECT_TRUE(block_height != 2000 || decoder.restarts() == 0);
    }
  }
}

TEST(SpilledRows, ReleasedRowsGiveTheirDiskSpaceBackAndCanBeReadAgain) {
  const TempFolder folder;
  for (const bool sequential : {false, true}) {
    const CellGrid grid = grid_of(sequential, sequential ? 2000 : 7);
    const CountingDecoder decoder(grid);
    const auto scratch = std::make_shared<ScratchFile>(folder.path());
    {
      SpilledRows rows(decoder, 0, scratch);
      std::uint64_t most = 0;
      for (std::int64_t row = 0; row < 2000; row += 50) {
        rows.release_rows_before(row - 100);
        expect_rows(rows, {.row = row, .rows = 50, .column = 10, .columns = 200});
        most = std::max(most, scratch->bytes_on_disk());
      }
      const std::uint64_t row_bytes = 301 * 4;
      EXPECT_LE(most, (100 + 50 + SpilledRows::kKeptRows + 7) * row_bytes + 4 * ScratchFile::kPageBytes);
      for (std::int64_t cell = 0; cell < grid.cells_down(); ++cell) EXPECT_EQ(decoder.decoded(cell), 1);

      // Against the hint, in any order and beside further hints.
      std::vector<std::jthread> threads;
      for (std::uint32_t seed = 0; seed < 3; ++seed) {
        threads.emplace_back([&, seed] {
          std::mt19937 random(seed);
          for (int i = 0; i < 100; ++i) {
            rows.release_rows_before(static_cast<std::int64_t>(random() % 2000));
            expect_rows(rows, {.row = static_cast<std::int64_t>(random() % 1980), .rows = 20, .column = 0, .columns = 301});
          }
        });
      }
    }
    EXPECT_LE(scratch->bytes_on_disk(), ScratchFile::kPageBytes) << "a source that is gone holds nothing";
  }
}

// What lies above the rows that are wanted is passed over without being kept: a build that goes on in the
// middle.
TEST(SpilledRows, RowsAboveTheHintAreNotKept) {
  const TempFolder folder;
  const CellGrid grid = grid_of(true, 2000);
  const CountingDecoder decoder(grid);
  const auto scratch = std::make_shared<ScratchFile>(folder.path());
  SpilledRows rows(decoder, 0, scratch);
  rows.release_rows_before(1500);
  expect_rows(rows, {.row = 1600, .rows = 10, .column = 0, .columns = 301});
  EXPECT_EQ(decoder.decoded(0), 0);
  EXPECT_LE(scratch->bytes_on_disk(), (110 + SpilledRows::kKeptRows + 14) * 301 * 4U + 2 * ScratchFile::kPageBytes);
}

TEST(SpilledRows, AFailureIsReportedAndTriedAgain) {
  const TempFolder folder;
  for (const bool sequential : {false, true}) {
    CountingDecoder decoder(grid_of(sequential, sequential ? 2000 : 7));
    SpilledRows rows(decoder, 0, std::make_shared<ScratchFile>(folder.path()));
    decoder.fails_at = 3;
    std::vector<std::byte> out(301 * 4);
    expect_rows(rows, {.row = 7, .rows = 5, .column = 3, .columns = 1});
    const auto read = rows.read({.row = 70, .rows = 1, .column = 0, .columns = 301}, out);
    EXPECT_EQ(read.has_value(), !sequential);
    const auto damaged = rows.read({.row = 22, .rows = 1, .column = 0, .columns = 301}, out);
    ASSERT_FALSE(damaged.has_value());
    EXPECT_EQ(damaged.error().code, ErrorCode::kCorrupt);
    decoder.fails_at = -1;
    expect_rows(rows, {.row = 0, .rows = 2000, .column = 0, .columns = 301});
  }
}

TEST(SpilledRows, AFullDiskIsSaidSo) {
  const TempFolder folder;
  const CountingDecoder decoder(grid_of(true, 2000));
  SpilledRows rows(decoder, 0, std::make_shared<ScratchFile>(folder.path(), 200000));
  std::vector<std::byte> out(301 * 4);
  expect_rows(rows, {.row = 0, .rows = 50, .column = 0, .columns = 301});
  auto read = rows.read({.row = 1999, .rows = 1, .column = 0, .columns = 301}, out);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kIo);
  EXPECT_NE(read.error().message.find(folder.path().string()), std::string::npos);
  EXPECT_NE(read.error().message.find("No space left"), std::string::npos) << read.error().message;
  expect_rows(rows, {.row = 0, .rows = 50, .column = 0, .columns = 301});

  // The same from the operating system itself: a file may not grow beyond the process's limit.
  struct rlimit limit {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  struct rlimit small = limit;
  small.rlim_cur = 300000;
  const auto on_too_large = ::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  SpilledRows others(decoder, 0, std::make_shared<ScratchFile>(folder.path()));
  read = others.read({.row = 1999, .rows = 1, .column = 0, .columns = 301}, out);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  ::signal(SIGXFSZ, on_too_large);
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().code, ErrorCode::kIo);
  EXPECT_NE(read.error().message.find("free some space"), std::string::npos) << read.error().message;

  SpilledRows nowhere(decoder, 0, std::make_shared<ScratchFile>(folder / "absent"));
  EXPECT_FALSE(nowhere.read({.row = 0, .rows = 1, .column = 0, .columns = 301}, out).has_value());
}

TEST(ScratchFile, HasNoNameAndKeepsRangesApart) {
  const TempFolder folder;
  ScratchFile scratch(folder.path());
  const auto first = scratch.reserve(5000);
  const auto second = scratch.reserve(1);
  ASSERT_TRUE(first && second);
  EXPECT_GE(*second, *first + 5000);
  EXPECT_EQ(*second % ScratchFile::kPageBytes, 0U);
  const std::vector<std::byte> a(5000, std::byte{1});
  const std::vector<std::byte> b(1, std::byte{2});
  ASSERT_TRUE(scratch.write(*first, a) && scratch.write(*second, b));
  std::vector<std::byte> back(5000);
  ASSERT_TRUE(scratch.read(*first, back));
  EXPECT_EQ(back, a);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace vt::source
