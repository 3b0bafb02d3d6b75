#include "runtime/sub_load.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "runtime/tile_loader.h"

namespace vt::runtime {
namespace {

TEST(BandCursor, CutsATileIntoPiecesThatFitAndTogetherAreTheTile) {
  std::mt19937 random(21);
  for (const TexelFormat format : {TexelFormat::kRgb8, TexelFormat::kRgba8, TexelFormat::kBc1, TexelFormat::kR32Float}) {
    const FormatInfo& info = format_info(format);
    for (int trial = 0; trial < 40; ++trial) {
      const int exponent = 5 + static_cast<int>(random() % 4);
      const int mips = 1 + static_cast<int>(random() % static_cast<unsigned>(exponent - 2));
      BandCursor cursor(format, exponent, mips);
      std::size_t offset = 0;
      std::vector<std::vector<int>> seen(static_cast<std::size_t>(mips));
      for (int m = 0; m < mips; ++m) seen[static_cast<std::size_t>(m)].assign(std::size_t{1} << (2 * (exponent - m)), 0);
      while (!cursor.done()) {
        const std::size_t most = 1 + random() % (trial % 2 == 0 ? 300 : 20000);
        const auto band = cursor.next(most);
        if (!band) {
          ASSERT_LT(most, info.block_bytes);
          continue;
        }
        ASSERT_LE(band->bytes, most);
        ASSERT_GT(band->bytes, 0U);
        ASSERT_EQ(band->offset, offset) << "bands are contiguous";
        offset += band->bytes;
        ASSERT_EQ(band->bytes, payload_bytes(info, static_cast<std::size_t>(band->width), static_cast<std::size_t>(band->height)));
        const int edge = 1 << (exponent - band->mip);
        ASSERT_LE(band->x + band->width, edge);
        ASSERT_LE(band->y + band->height, edge);
        for (int y = band->y; y < band->y + band->height; ++y)
          for (int x = band->x; x < band->x + band->width; ++x)
            ++seen[static_cast<std::size_t>(band->mip)][static_cast<std::size_t>(y * edge + x)];
      }
      EXPECT_EQ(offset, tile_bytes(info, exponent, mips));
      for (const auto& mip : seen) EXPECT_EQ(std::count(mip.begin(), mip.end(), 1), static_cast<std::ptrdiff_t>(mip.size()));
    }
  }
}

TEST(BandCursor, GivesNothingBelowOneBlock) {
  BandCursor cursor(TexelFormat::kBc1, 6, 1);
  EXPECT_FALSE(cursor.next(0));
  EXPECT_FALSE(cursor.next(7));
  EXPECT_TRUE(cursor.next(8));
}

TEST(SubLoadController, WithoutABudgetOfTimeItsBytesAlone) {
  SubLoadController controller(10000, 0.0);
  for (int frame = 0; frame < 10; ++frame) {
    EXPECT_EQ(controller.bytes_per_update(), 10000U);
    controller.record(7000, 1.0);
    controller.record(3000, 1e-9);
  }
}

TEST(SubLoadController, LearnsTheRateAndKeepsTheTime) {
  SubLoadController controller(1 << 30, 0.001);
  // A bus of 1 GB/s with 20 % of noise: a millisecond is a million bytes.
  std::mt19937 random(22);
  std::uniform_real_distribution<double> noise(0.8, 1.2);
  for (int frame = 0; frame < 200; ++frame) {
    const std::size_t bytes = controller.bytes_per_update();
    controller.record(bytes, static_cast<double>(bytes) * 1e-9 * noise(random));
  }
  EXPECT_NEAR(static_cast<double>(controller.bytes_per_update()), 1e6, 0.15e6);
  // The driver becomes ten times slower: the next frames follow.
  for (int frame = 0; frame < 60; ++frame) {
    const std::size_t bytes = controller.bytes_per_update();
    controller.record(bytes, static_cast<double>(bytes) * 1e-8);
  }
  EXPECT_NEAR(static_cast<double>(controller.bytes_per_update()), 1e5, 0.1e5);
}

TEST(SubLoadController, OneLongStallDoesNotStopItForGood) {
  SubLoadController controller(1 << 20, 0.001);
  controller.record(controller.bytes_per_update(), 10.0);
  EXPECT_GT(controller.bytes_per_update(), 0U);
  for (int frame = 0; frame < 400; ++frame) {
    const std::size_t bytes = controller.bytes_per_update();
    controller.record(bytes, static_cast<double>(bytes) * 1e-9);
  }
  EXPECT_GT(controller.bytes_per_update(), 500000U);
}

}  // namespace
}  // namespace vt::runtime
