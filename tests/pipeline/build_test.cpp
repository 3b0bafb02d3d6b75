#include <gtest/gtest.h>

#include "builder/channels/codec/channel_codec.h"
#include "builder/encode/block_encoder.h"
#include "builder/pipeline/build/build_memory.h"
#include "builder/pyramid/halving_kernel.h"
#include "tests/pipeline/layers/layer_kinds.h"
#include "tests/support/whole_image.h"

namespace vt::pipeline {
namespace {

// The same tiles from the definition: decode all, halve whole levels, encode whole rows, cut.
Tiles tiles_by_definition(const Case& c, const LayerPlan& plan) {
  Tiles tiles;
  const channels::ChannelCodec& codec = plan.sampler->codec();
  const LayerInfo& info = plan.info;
  const int planes = codec.planes();
  const test::PlaneRules rules{{codec.rules().begin(), codec.rules().end()}, codec.weight_plane()};
  test::WholeImage image(plan.shape(), 0, planes);
  resample::BaseChunk chunk;
  EXPECT_TRUE(plan.sampler->load({0, 0, info.data.width, info.data.height}, chunk).has_value());
  std::vector<std::vector<float>> row(static_cast<std::size_t>(planes), std::vector<float>(static_cast<std::size_t>(info.data.width)));
  channels::PlaneRow pointers{};
  for (int p = 0; p < planes; ++p) pointers[static_cast<std::size_t>(p)] = row[static_cast<std::size_t>(p)].data();
  for (std::int64_t y = 0; y < info.data.height; ++y) {
    chunk.decode_row(y, pointers);
    for (std::int64_t x = 0; x < info.data.width; ++x)
      for (int p = 0; p < planes; ++p) image.at(x, y, p) = row[static_cast<std::size_t>(p)][static_cast<std::size_t>(x)];
  }

  const std::size_t texel_bytes = format_info(codec.parts().front().texel_format).block_bytes;
  const std::int64_t edge = info.tile_texels();
  for (int level = info.finest.value;; --level) {
    const Level l{static_cast<std::uint8_t>(level)};
    const bool copied = level == info.finest.value && plan.sampler->passes_texels();
    const TexelRect rect = info.tile_rect(l);
    const bool moves = codec.centre_range() && !plan.kernel.is_point;
    const test::WholeImage stored = moves ? test::at_centres(image, *codec.centre_range(), rules) : image;
    for (std::int64_t ty = rect.y; ty < rect.bottom(); ++ty)
      for (std::int64_t tx = rect.x; tx < rect.right(); ++tx) {
        const TileId id{l, static_cast<std::uint32_t>(tx), static_cast<std::uint32_t>(ty)};
        std::vector<std::byte> texels(static_cast<std::size_t>(edge * edge) * texel_bytes);
        bool has_data = false;
        for (std::int64_t y = 0; y < edge; ++y)
          for (std::int64_t x = 0; x < edge; ++x) {
            const std::int64_t px = tx * edge + x;
            const std::int64_t py = ty * edge + y;
            // Outside the data: the nearest texel that is inside.
            const std::int64_t qx = std::clamp(px, image.data.x, image.data.right() - 1);
            const std::int64_t qy = std::clamp(py, image.data.y, image.data.bottom() - 1);
            std::byte* out = texels.data() + static_cast<std::size_t>(y * edge + x) * texel_bytes;
            if (copied) {
              std::memcpy(out, chunk.texel_row(qy) + static_cast<std::size_t>(qx) * texel_bytes, texel_bytes);
            } else {
              // With the texel to its east or west, because a row begins in an even column.
              const std::int64_t first = qx & ~std::int64_t{1};
              std::array<std::array<std::array<float, 4>, channels::kMaxPlanes>, 3> around{};
              channels::RowNeighbourhood rows;
              for (std::size_t r = 0; r < 3; ++r)
                for (int p = 0; p < planes; ++p) {
                  const auto plane = static_cast<std::size_t>(p);
                  for (int i = 0; i < 4; ++i)
                    around[r][plane][static_cast<std::size_t>(i)] = stored.seen(first + i - 1, qy + static_cast<int>(r) - 1, p, rules);
                  (r == 0 ? rows.above : r == 1 ? rows.here : rows.below)[plane] = around[r][plane].data() + 1;
                }
              std::vector<std::byte> pair(2 * texel_bytes);
              EXPECT_TRUE(codec.encode_row(0, rows, 2, pair.data()).has_value());
              std::memcpy(out, pair.data() + static_cast<std::size_t>(qx - first) * texel_bytes, texel_bytes);
            }
            if (px != qx || py != qy) codec.mark_outside(0, out, 1);
            has_data = has_data || image.get(px, py, codec.weight_plane()) > 0.0F;
          }
        if (!has_data) continue;
        if (format_info(info.format).block_edge == 4) {
          std::vector<std::byte> blocks(info.tile_payload_bytes());
          encode::encode_blocks(info.format, texels, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge),
                                static_cast<std::size_t>(edge) * texel_bytes, plan.request.quality, blocks);
          texels = std::move(blocks);
        }
        tiles.emplace(id, std::move(texels));
      }
    if (level == 0) break;
    image = test::halve_whole(image, plan.kernel, rules);
  }
  EXPECT_FALSE(c.name.empty());
  return tiles;
}

TEST(Build, TilesAreThoseOfTheWholeImageAtAnyThreadCountAndBlockSize) {
  for (const Case& c : cases()) {
    if (c.channel == ChannelType::kMaterial) continue;  // classes are counted, see material_layer_test.cpp
    const test::TempFolder folder;
    write_raster(folder / "input.tif", c.raster, c.value);
    const LayerRequest request = request_of(c, folder / "input.tif");
    auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
    ASSERT_TRUE(plan.has_value()) << c.name << ": " << plan.error().message;
    if (plan->part(0).ends_at_base) continue;  // the other levels are made after the blocks, by a pass with tests of its own
    const Tiles wanted = tiles_by_definition(c, *plan);
    for (const int threads : {1, 2, 4})
      for (const int block_levels : {1, 2, 5}) {
        const auto path = folder / ("store-" + std::to_string(threads) + "-" + std::to_string(block_levels) + ".vts");
        build(path, request, {.threads = threads, .block_levels = block_levels});
        const Tiles found = tiles_of(path, request.name);
        ASSERT_EQ(found.size(), wanted.size()) << c.name;
        for (const auto& [tile, texels] : wanted)
          ASSERT_TRUE(found.at(tile) == texels) << c.name << ", " << threads << " threads, block " << block_levels << ": level "
                                                << int{tile.level.value} << " tile " << tile.x << "," << tile.y;
      }
  }
}

TEST(Build, MemoryDecidesTheBlockAndNothingElse) {
  const test::TempFolder folder;
  const Case c = cases().front();
  write_raster(folder / "input.tif", c.raster, c.value);
  LayerRequest request = request_of(c, folder / "input.tif");
  build(folder / "large.vts", request, {.threads = 1, .memory_bytes = std::size_t{512} << 20});
  build(folder / "small.vts", request, {.threads = 1, .memory_bytes = std::size_t{50} << 20});
  EXPECT_EQ(tiles_of(folder / "large.vts", "color"), tiles_of(folder / "small.vts", "color"));
  auto plan = plan_layer(request, std::nullopt, 1 << 20);
  const auto refused = choose_block_levels(*plan, 2, std::size_t{1} << 20);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  EXPECT_NE(refused.error().message.find("at least"), std::string::npos);
}

TEST(Build, ASecondRunFindsNothingToDoAndAnotherSettingIsRefused) {
  const test::TempFolder folder;
  const Case c = cases().front();
  write_raster(folder / "input.tif", c.raster, c.value);
  LayerRequest request = request_of(c, folder / "input.tif");
  EXPECT_FALSE(build(folder / "a.vts", request).was_complete);
  EXPECT_TRUE(build(folder / "a.vts", request).was_complete);
  request.kernel = "box";
  auto frame = existing_frame(folder / "a.vts");
  auto plan = plan_layer(request, *frame, 1 << 20);
  auto writer = open_or_create(folder / "a.vts", plan->crs, plan->extent());
  const auto refused = build_layer(*writer, *plan, {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kExists);
}

TEST(Build, ASecondLayerLeavesTheFirstUntouched) {
  const test::TempFolder folder;
  const std::vector<Case> all = cases();
  write_raster(folder / "image.tif", all[0].raster, all[0].value);
  write_raster(folder / "height.tif", all[6].raster, all[6].value);
  build(folder / "a.vts", request_of(all[0], folder / "image.tif"));
  const Tiles before = tiles_of(folder / "a.vts", "color");
  build(folder / "a.vts", request_of(all[6], folder / "height.tif"));
  EXPECT_EQ(tiles_of(folder / "a.vts", "color"), before);
  EXPECT_FALSE(tiles_of(folder / "a.vts", "elevation").empty());
}

// A stopped build keeps whole blocks; going on does only the rest, and nothing in the result tells.
TEST(Build, GoesOnWhereItWasStopped) {
  const test::TempFolder folder;
  Case c = cases().front();
  c.raster.width = 700;
  c.raster.height = 500;
  write_raster(folder / "input.tif", c.raster, c.value);
  const LayerRequest request = request_of(c, folder / "input.tif");
  build(folder / "whole.vts", request, {.threads = 1, .block_levels = 1});
  const Tiles wanted = tiles_of(folder / "whole.vts", "color");
  for (const int stop_after_percent : {0, 20, 50, 90}) {
    const auto path = folder / ("stopped-" + std::to_string(stop_after_percent) + ".vts");
    auto plan = plan_layer(request, std::nullopt, 1 << 20);
    std::atomic<bool> cancel{false};
    BuildOptions options{.threads = 2, .block_levels = 1, .cancel = &cancel};
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
      cancel = cancel || done * 100 > total * static_cast<std::uint64_t>(stop_after_percent);
    };
    {
      auto writer = open_or_create(path, plan->crs, plan->extent());
      const auto stopped = build_layer(*writer, *plan, options);
      ASSERT_FALSE(stopped.has_value());
      ASSERT_EQ(stopped.error().code, ErrorCode::kCancelled);
      auto reader = store::StoreReader::open(path);
      ASSERT_TRUE(reader.has_value());
      EXPECT_EQ(reader->find_layer("color")->state, LayerState::kBuilding);
    }
    // Another block size was asked for; the store remembers the one it was begun with.
    const BuildReport report = build(path, request, {.threads = 2, .block_levels = 3});
    EXPECT_EQ(report.block_levels, 1);
    if (stop_after_percent >= 50) {
      EXPECT_GT(report.blocks_resumed, 0);
    }
    EXPECT_EQ(tiles_of(path, "color"), wanted) << "stopped after " << stop_after_percent << " %";
  }
}

}  // namespace
}  // namespace vt::pipeline
