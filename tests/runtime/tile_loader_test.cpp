#include "runtime/tile_loader.h"

#include <gtest/gtest.h>

#include <cstring>
#include <latch>
#include <semaphore>
#include <thread>
#include <utility>

#include "store/region.h"
#include "store/texel/bc1.h"
#include "tests/runtime/test_store.h"

namespace vt::runtime {
namespace {

using test::LayerSpec;
using test::make_store;
using test::noise_paint;
using test::Paint;
using test::PaintedSource;
using test::TempFolder;

// However busy the machine is.
TileImage* wait_for(TileLoader& loader) {
  while (true) {
    if (TileImage* image = loader.take()) return image;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

LevelLayout level_layout(int level, int exponent, int mips) {
  return {.level = Level{static_cast<std::uint8_t>(level)},
          .tile_exponent = exponent,
          .tiles_per_side = 1,
          .mips = mips,
          .hop = 1 << (exponent - 1)};
}

// What a mip must be, from the formula alone; `present` says which texels of a level were written, holes come
// from coarser levels.
std::vector<std::byte> expected_mip(const LayerInfo& layer, const Paint& paint, const std::function<bool(TileId)>& skip, Level level,
                                    const TexelRect& rect) {
  const FormatInfo& format = format_info(layer.format);
  std::vector<std::byte> out(payload_bytes(format, static_cast<std::size_t>(rect.width), static_cast<std::size_t>(rect.height)));
  std::byte* to = out.data();
  for (std::int64_t y = rect.y; y < rect.bottom(); ++y)
    for (std::int64_t x = rect.x; x < rect.right(); ++x, to += format.block_bytes) {
      for (int up = 0; up <= level.value; ++up) {
        const Level coarse{static_cast<std::uint8_t>(level.value - up)};
        const std::int64_t cx = x >> up;
        const std::int64_t cy = y >> up;
        const TileId tile{coarse, static_cast<std::uint32_t>(cx >> layer.tile_exponent),
                          static_cast<std::uint32_t>(cy >> layer.tile_exponent)};
        const TexelRect tiles = layer.tile_rect(coarse);
        if (!tiles.contains(tile.x, tile.y) || (skip && skip(tile))) continue;
        paint(coarse, cx, cy, to);
        break;
      }
    }
  return out;
}

void expect_mips(const TileImage& image, const LayerInfo& layer, const Paint& paint, const std::function<bool(TileId)>& skip,
                 const TileRequest& request) {
  const FormatInfo& format = format_info(image.format);
  for (int mip = 0; mip < image.mips; ++mip) {
    const std::int64_t edge = request.level.tile_texels() >> mip;
    const Level level{static_cast<std::uint8_t>(request.level.level.value - mip)};
    const auto want = expected_mip(layer, paint, skip, level, {request.origin.x >> mip, request.origin.y >> mip, edge, edge});
    ASSERT_EQ(std::memcmp(image.bytes.data() + mip_offset(format, image.tile_exponent, mip), want.data(), want.size()), 0) << "mip " << mip;
  }
}

TEST(TileLoader, MipsAreTheStoresOwnLevelsByteForByte) {
  TempFolder folder;
  const LayerSpec spec{.format = TexelFormat::kRgb8, .tile_exponent = 5, .finest = 4, .data = {}, .paint = {}, .skip = {}};
  const auto reader = make_store(folder / "a.vts", {spec});
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo& layer = (*reader)->layers()[0];
  TileLoader loader(std::make_shared<StoreTileSource>(*reader, layer.id), {}, 7, 5, 2, 16);
  const TileRequest request{.slot = 3, .ticket = 9, .level = level_layout(4, 7, 5), .levels_from_finest = 0, .origin = {112, 240}};
  loader.post(std::span(&request, 1));
  TileImage* image = wait_for(loader);
  ASSERT_NE(image, nullptr);
  ASSERT_TRUE(image->ok) << loader.last_error();
  EXPECT_EQ(image->slot, 3);
  EXPECT_EQ(image->ticket, 9U);
  expect_mips(*image, layer, noise_paint(spec.format), nullptr, request);
  loader.release(image);
}

TEST(TileLoader, HolesAreFilledFromCoarserLevelsAndOddSizesEndWhereTheDataEnds) {
  TempFolder folder;
  // Islands: most fine tiles are missing; the data rectangle is odd.
  const auto skip = [](TileId tile) { return tile.level.value >= 2 && (tile.x * 7 + tile.y * 3 + tile.level.value) % 3 != 0; };
  const LayerSpec spec{.format = TexelFormat::kRgba8, .tile_exponent = 5, .finest = 4, .data = {3, 5, 399, 277}, .paint = {}, .skip = skip};
  const auto reader = make_store(folder / "b.vts", {spec});
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo& layer = (*reader)->layers()[0];
  TileLoader loader(std::make_shared<StoreTileSource>(*reader, layer.id), {.source = spec.format, .target = spec.format}, 7, 4, 2, 16);
  for (const TexelOrigin origin : {TexelOrigin{0, 0}, {64, 128}, {320, 192}, {384, 256}}) {
    const TileRequest request{.slot = 0, .ticket = 1, .level = level_layout(4, 7, 4), .levels_from_finest = 0, .origin = origin};
    loader.post(std::span(&request, 1));
    TileImage* image = wait_for(loader);
    ASSERT_NE(image, nullptr);
    ASSERT_TRUE(image->ok) << loader.last_error();
    expect_mips(*image, layer, noise_paint(spec.format), skip, request);
    loader.release(image);
  }
}

TEST(TileLoader, Bc1StaysCompressedOrIsDecodedAsTheContextNeeds) {
  TempFolder folder;
  // Four-colour blocks: the first end point is the larger number.
  const Paint paint = [](Level level, std::int64_t x, std::int64_t y, std::byte* block) {
    noise_paint(TexelFormat::kBc1)(level, x, y, block);
    block[1] |= std::byte{0x80};
    block[3] &= std::byte{0x7F};
  };
  const LayerSpec spec{.format = TexelFormat::kBc1, .tile_exponent = 6, .finest = 3, .data = {}, .paint = paint, .skip = {}};
  const auto reader = make_store(folder / "c.vts", {spec});
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo& layer = (*reader)->layers()[0];
  const TileRequest request{.slot = 0, .ticket = 1, .level = level_layout(3, 7, 4), .levels_from_finest = 0, .origin = {64, 96}};
  const auto source = std::make_shared<StoreTileSource>(*reader, layer.id);

  TileLoader blocks(source, {.source = TexelFormat::kBc1, .target = TexelFormat::kBc1}, 7, 4, 1, 4);
  blocks.post(std::span(&request, 1));
  TileImage* compressed = wait_for(blocks);
  ASSERT_NE(compressed, nullptr);
  ASSERT_TRUE(compressed->ok) << blocks.last_error();
  TileLoader texels(source, {.source = TexelFormat::kBc1, .target = TexelFormat::kRgba8}, 7, 4, 1, 4);
  texels.post(std::span(&request, 1));
  TileImage* decoded = wait_for(texels);
  ASSERT_NE(decoded, nullptr);
  ASSERT_TRUE(decoded->ok);

  for (int mip = 0; mip < 4; ++mip) {
    const std::int64_t edge = 128 >> mip;
    std::vector<std::byte> want;
    for (std::int64_t y = 0; y < edge / 4; ++y)
      for (std::int64_t x = 0; x < edge / 4; ++x) {
        want.resize(want.size() + 8);
        paint(Level{static_cast<std::uint8_t>(3 - mip)}, (64 >> mip) / 4 + x, (96 >> mip) / 4 + y, want.data() + want.size() - 8);
      }
    ASSERT_EQ(std::memcmp(compressed->bytes.data() + mip_offset(format_info(TexelFormat::kBc1), 7, mip), want.data(), want.size()), 0)
        << "mip " << mip;
    // Decoded block by block by the store's definition.
    const std::byte* rgba = decoded->bytes.data() + mip_offset(format_info(TexelFormat::kRgba8), 7, mip);
    for (std::int64_t b = 0; b < edge / 4 * (edge / 4); ++b) {
      const store::Bc1Texels block = store::decode_bc1_block(std::span<const std::byte, 8>(want.data() + b * 8, 8));
      for (std::int64_t i = 0; i < 16; ++i) {
        const std::int64_t x = b % (edge / 4) * 4 + i % 4;
        const std::int64_t y = b / (edge / 4) * 4 + i / 4;
        ASSERT_EQ(std::memcmp(rgba + (y * edge + x) * 4, block[static_cast<std::size_t>(i)].data(), 4), 0);
      }
    }
  }
}

TEST(TileLoader, ReadsInTheOrderOfTheRequests) {
  auto source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  TileLoader loader(source, {}, 5, 1, 8, 8);
  std::vector<TileRequest> requests;
  for (int i = 0; i < 8; ++i)
    requests.push_back({.slot = i, .ticket = 1, .level = level_layout(6, 5, 1), .levels_from_finest = 0, .origin = {}});
  loader.post(requests);
  for (int i = 0; i < 8; ++i) {
    TileImage* image = wait_for(loader);
    ASSERT_NE(image, nullptr);
    EXPECT_EQ(image->slot, i);
    loader.release(image);
  }
}

TEST(TileLoader, GivesUpWhatNobodyWantsAnyMore) {
  auto source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  std::binary_semaphore may_read{0};  // the first mip is read until something else is wanted
  bool is_first = true;
  source->during_read = [&] {
    if (std::exchange(is_first, false)) may_read.acquire();
  };
  TileLoader loader(source, {}, 5, 5, 2, 8);
  const TileRequest old_one{.slot = 0, .ticket = 1, .level = level_layout(6, 5, 5), .levels_from_finest = 0, .origin = {}};
  const TileRequest new_one{.slot = 0, .ticket = 2, .level = level_layout(6, 5, 1), .levels_from_finest = 0, .origin = {32, 32}};
  loader.post(std::span(&old_one, 1));
  while (source->reads == 0) std::this_thread::yield();
  loader.post(std::span(&new_one, 1));
  may_read.release();
  TileImage* image = wait_for(loader);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->ticket, 2U);
  EXPECT_EQ(loader.counters().tiles_cancelled, 1U);
  loader.release(image);
}

TEST(TileLoader, DoesNotReadAgainWhatIsInWorkOrFinished) {
  auto source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  TileLoader loader(source, {}, 5, 1, 2, 8);
  const TileRequest request{.slot = 0, .ticket = 1, .level = level_layout(6, 5, 1), .levels_from_finest = 0, .origin = {}};
  loader.post(std::span(&request, 1));
  for (int i = 0; i < 100; ++i) {
    loader.post(std::span(&request, 1));
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  TileImage* image = wait_for(loader);
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(source->reads, 1);
  loader.release(image);
}

TEST(TileLoader, ReportsATileThatCannotBeRead) {
  auto source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  source->fail_level = 5;
  TileLoader loader(source, {}, 5, 2, 2, 8);
  const TileRequest request{.slot = 0, .ticket = 1, .level = level_layout(6, 5, 2), .levels_from_finest = 0, .origin = {}};
  loader.post(std::span(&request, 1));
  TileImage* image = wait_for(loader);
  ASSERT_NE(image, nullptr);
  EXPECT_FALSE(image->ok);
  EXPECT_EQ(loader.last_error(), "painted to fail");
  EXPECT_EQ(loader.counters().tiles_failed, 1U);
  loader.release(image);
}

TEST(TileLoader, TintsEveryMipWithItsTilesColour) {
  auto source = std::make_shared<PaintedSource>(
      TexelFormat::kRgb8, [](Level, std::int64_t, std::int64_t, std::byte* t) { t[0] = t[1] = t[2] = std::byte{100}; });
  TileLoader loader(source, {.source = TexelFormat::kRgb8, .target = TexelFormat::kRgb8, .tint_levels = true}, 5, 3, 2, 8);
  const TileRequest request{.slot = 0, .ticket = 1, .level = level_layout(6, 5, 3), .levels_from_finest = 2, .origin = {}};
  loader.post(std::span(&request, 1));
  TileImage* image = wait_for(loader);
  ASSERT_NE(image, nullptr);
  for (std::size_t i = 0; i < tile_bytes(format_info(TexelFormat::kRgb8), 5, 3); ++i)
    ASSERT_EQ(std::to_integer<int>(image->bytes[i]), (100 + tint_colour(2)[i % 3]) / 2);
  loader.release(image);
}

TEST(TileLoader, StopsWithWorkWaiting) {
  const std::vector<TileRequest> requests(64,
                                          {.slot = 0, .ticket = 1, .level = level_layout(6, 5, 1), .levels_from_finest = 0, .origin = {}});
  // It waits for a place to put the next tile into.
  auto source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  {
    TileLoader loader(source, {}, 5, 1, 4, 64);
    loader.post(requests);
    while (source->reads < 4) std::this_thread::yield();
  }
  EXPECT_EQ(source->reads, 4);

  // It is in the middle of one; there are places for all.
  source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
  std::latch is_going{1};
  source->during_read = [&] { is_going.wait(); };
  auto loader = std::make_unique<TileLoader>(source, TexelConversion{}, 5, 1, 64, 64);
  loader->post(requests);
  while (source->reads == 0) std::this_thread::yield();
  const std::jthread end([&] {
    is_going.count_down();
    loader.reset();
  });
}

}  // namespace
}  // namespace vt::runtime
