// Datasets far larger than any disk here: planned from a description, from a file that is nearly all holes,
// and built where there is something to build.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "builder/pipeline/build/build_memory.h"
#include "builder/pipeline/build/plan_cost.h"
#include "builder/pipeline/request/scene_file.h"
#include "tests/pipeline/big_tiff.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

using testing::HasSubstr;

const PlanOptions kPlanOnly{.may_lack_sources = true};

Scene scene_from(const test::TempFolder& folder, const std::string& text) {
  std::ofstream(folder / "SCENE.json") << text;
  auto scene = read_scene(folder / "SCENE.json");
  EXPECT_TRUE(scene.has_value()) << (scene ? "" : scene.error().message);
  return scene.value_or(Scene{});
}

// 900 x 700 km at 0.8 m: 1,125,000 x 875,000 texels.
constexpr const char* kCountry = R"({"format": "vt-scene", "version": 1, "name": "country", "crs": "EPSG:32633",
  "area": {"west": 100000, "south": 5000000, "east": 1000000, "north": 5700000},
  "layers": [{"name": "color", "channel": "color", "gsd": 0.8, "expect": {"type": "uint8", "bands": 3}},
             {"name": "elevation", "channel": "elevation", "gsd": 0.8, "sources": ["later.tif"],
              "expect": {"type": "float32", "bands": 1, "nodata": -9999}}]})";

// Definition: every level on its own, from the size of the finest one.
PlanCost counted(std::uint64_t width, std::uint64_t height, std::uint64_t tile, std::uint64_t tile_bytes) {
  PlanCost cost;
  const auto divided = [](std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; };
  for (std::uint64_t scale = 1;; scale *= 2) {
    const std::uint64_t w = divided(width, scale);
    const std::uint64_t h = divided(height, scale);
    cost.texels += w * h;
    cost.tiles += divided(w, tile) * divided(h, tile);
    if (w <= tile && h <= tile) break;
  }
  cost.raw_bytes = cost.tiles * tile_bytes;
  return cost;
}

void expect_cost(const LayerPlan& plan, std::uint64_t width, std::uint64_t height) {
  EXPECT_EQ(plan.info.data.width, static_cast<std::int64_t>(width));
  EXPECT_EQ(plan.info.data.height, static_cast<std::int64_t>(height));
  const PlanCost cost = plan_cost(plan.info);
  const PlanCost wanted = counted(width, height, plan.info.tile_texels(), plan.info.tile_payload_bytes());
  EXPECT_EQ(cost.texels, wanted.texels);
  EXPECT_EQ(cost.tiles, wanted.tiles);
  EXPECT_EQ(cost.raw_bytes, wanted.raw_bytes);
}

// Blocks of every tier cover its level, and the last one lies in its corner.
void expect_tiers(const LayerPlan& plan, int levels) {
  for (const Tier& tier : plan_tiers(plan.info, levels)) {
    const std::int64_t across = (tier.data.width + tier.block_texels - 1) / tier.block_texels;
    const std::int64_t down = (tier.data.height + tier.block_texels - 1) / tier.block_texels;
    EXPECT_EQ(tier.blocks(), across * down);
    const TexelRect last = tier.block(tier.blocks() - 1);
    EXPECT_EQ(last.x, (across - 1) * tier.block_texels);
    EXPECT_EQ(last.y, (down - 1) * tier.block_texels);
    if (!tier.has_carry) continue;
    EXPECT_EQ(tier.block_of_carry(tier.carry_tile(tier.blocks() - 1)), tier.blocks() - 1);
  }
}

TEST(HugePlan, ACountryIsPlannedFromItsDescription) {
  const test::TempFolder folder;
  const Scene scene = scene_from(folder, kCountry);
  ASSERT_EQ(scene.layers.size(), 2U);
  for (const LayerRequest& request : scene.layers) {
    const auto plan = plan_layer(request, std::nullopt, kPlanOnly);
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    EXPECT_EQ(plan->sampler, nullptr);
    expect_cost(*plan, 1'125'000, 875'000);
    const auto levels = choose_block_levels(*plan, 2, std::size_t{512} << 20);
    ASSERT_TRUE(levels.has_value()) << levels.error().message;
    EXPECT_EQ(*levels, 4);
    expect_tiers(*plan, *levels);

    const PlanEstimate estimate = estimate_cost(*plan, *levels, 2, 100.0);
    EXPECT_DOUBLE_EQ(estimate.seconds, 1'125'000.0 * 875'000.0 / 100e6);
    // 16 bytes for each tile, and little more.
    const PlanCost cost = plan_cost(plan->info);
    EXPECT_GE(estimate.index_bytes, cost.tiles * 16);
    EXPECT_LE(estimate.index_bytes, cost.tiles * 17);
    EXPECT_EQ(estimate.tile_bytes, static_cast<std::uint64_t>(std::llround(static_cast<double>(cost.raw_bytes) * estimate.tile_ratio)));
    EXPECT_GT(estimate.file_bytes, estimate.tile_bytes + estimate.working_state_bytes + estimate.index_bytes);
  }
}

TEST(HugePlan, TheEarthAtHalfAMetreDoesNotOverflow) {
  const test::TempFolder folder;
  const Scene scene = scene_from(folder, R"({"format": "vt-scene", "version": 1, "name": "earth", "crs": "EPSG:3857",
    "area": {"west": -20000000, "south": -10000000, "east": 20000000, "north": 10000000},
    "layers": [{"name": "color", "channel": "color", "gsd": 0.5, "expect": {"type": "uint8", "bands": 3}}]})");
  const auto plan = plan_layer(scene.layers.at(0), std::nullopt, kPlanOnly);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  expect_cost(*plan, 80'000'000, 40'000'000);
  for (const int levels : {1, 4}) expect_tiers(*plan, levels);
  // 4096 texels a block: 19532 x 9766 of them at the finest level alone.
  EXPECT_EQ(plan_tiers(plan->info, 4).front().blocks(), std::int64_t{19532} * 9766);
  EXPECT_FALSE(choose_block_levels(*plan, 2, std::size_t{64} << 20).has_value());
  EXPECT_EQ(cheapest_block_levels(*plan, 2), 4) << "large blocks make short lists";
}

TEST(HugePlan, WithoutSourcesItSaysWhatItNeedsAndIsNotBuilt) {
  const test::TempFolder folder;
  const LayerRequest elevation = scene_from(folder, kCountry).layers.at(1);
  const auto built = plan_layer(elevation, std::nullopt, PlanOptions{});
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().code, ErrorCode::kIo);
  EXPECT_THAT(built.error().message, testing::AllOf(HasSubstr("1 of 1"), HasSubstr("later.tif")));

  for (const auto& [leave_out, word] :
       std::vector<std::pair<std::function<void(LayerRequest&)>, std::string>>{{[](LayerRequest& r) { r.area.reset(); }, "area"},
                                                                               {[](LayerRequest& r) { r.gsd_m.reset(); }, "gsd"},
                                                                               {[](LayerRequest& r) { r.crs.reset(); }, "crs"}}) {
    LayerRequest request = elevation;
    leave_out(request);
    const auto plan = plan_layer(request, std::nullopt, kPlanOnly);
    ASSERT_FALSE(plan.has_value()) << word;
    EXPECT_THAT(plan.error().message, HasSubstr("it needs a")) << word;
    EXPECT_THAT(plan.error().message, HasSubstr(word));
  }
}

// A source that is there decides, even where samples are expected.
TEST(HugePlan, AFileThatIsNearlyAllHolesIsPlannedLikeAnyOther) {
  const test::TempFolder folder;
  write_unwritten_tiff(folder / "color.tif", 1'125'000, 875'000, 3, false, 100000.0, 5700000.0, 0.8);
  write_unwritten_tiff(folder / "later.tif", 1'125'000, 875'000, 1, true, 100000.0, 5700000.0, 0.8);
  LayerRequest color = request_for({folder / "color.tif"}, ChannelType::kColor);
  color.tile_texels = 256;
  const LayerRequest elevation = scene_from(folder, kCountry).layers.at(1);
  for (const LayerRequest& request : {color, elevation}) {
    const auto plan = plan_layer(request, std::nullopt, kPlanOnly);
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    ASSERT_NE(plan->sampler, nullptr);
    expect_cost(*plan, 1'125'000, 875'000);
    EXPECT_TRUE(choose_block_levels(*plan, 2, std::size_t{512} << 20).has_value());
    EXPECT_TRUE(plan->sampler->touches({1'124'999, 874'999, 1, 1}));
  }
}

// Three islands, each a few tiles, in a layer of 1,125,000 x 875,000 texels: what there is nothing for is
// neither visited nor stored.
TEST(HugePlan, AFewFilesFarApartBuildAtNominalSize) {
  const test::TempFolder folder;
  LayerRequest request;
  request.channel = ChannelType::kElevation;
  request.name = "elevation";
  request.area = Area{100000, 5000000, 1000000, 5700000};
  request.gsd_m = 0.8;
  const std::vector<std::pair<std::int64_t, std::int64_t>> corners{{0, 0}, {700'123, 400'321}, {1'124'700, 874'800}};
  for (const auto& [x, y] : corners) {
    RasterSpec spec{.width = 300, .height = 200, .bands = 1, .type = SampleType::kInt16};
    spec.transform = {100000.0 + static_cast<double>(x) * 0.8, 0.8, 0.0, 5700000.0 - static_cast<double>(y) * 0.8, 0.0, -0.8};
    request.sources.push_back({.path = folder / (std::to_string(x) + ".tif")});
    write_raster(request.sources.back().path, spec,
                 [x = x](std::int64_t i, std::int64_t j, int) { return static_cast<double>((x + i * 3 + j * 5) % 1000); });
  }
  const BuildReport report = build(folder / "sparse.vts", request, {.threads = 2});
  EXPECT_LT(report.tiles, 200U);

  auto reader = store::StoreReader::open(folder / "sparse.vts");
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const LayerInfo& layer = *reader->find_layer("elevation");
  EXPECT_EQ(layer.data.width, 1'125'000);
  EXPECT_EQ(layer.data.height, 875'000);
  std::vector<float> tile(256 * 256);
  const auto read = [&](std::int64_t x, std::int64_t y) {
    return reader->read(layer.id, {layer.finest, static_cast<std::uint32_t>(x / 256), static_cast<std::uint32_t>(y / 256)},
                        std::as_writable_bytes(std::span(tile)));
  };
  for (const auto& [x, y] : corners)
    for (const auto& [i, j] : std::vector<std::pair<std::int64_t, std::int64_t>>{{0, 0}, {299, 199}, {150, 7}}) {
      ASSERT_TRUE(read(x + i, y + j).has_value()) << x << "," << y;
      EXPECT_EQ(tile[static_cast<std::size_t>((y + j) % 256 * 256 + (x + i) % 256)], static_cast<float>((x + i * 3 + j * 5) % 1000));
    }
  EXPECT_EQ(read(300'000, 300'000).error().code, ErrorCode::kNotFound);
  // The root still has a little of each island.
  ASSERT_TRUE(reader->read(layer.id, {Level{0}, 0, 0}, std::as_writable_bytes(std::span(tile))).has_value());
  EXPECT_EQ(std::count_if(tile.begin(), tile.end(), [](float h) { return !std::isnan(h); }), 3);

  EXPECT_TRUE(build(folder / "sparse.vts", request, {.threads = 2}).was_complete);
}

TEST(Area, DecidesTheLayersExtentOnTheSourcesOwnGrid) {
  const test::TempFolder folder;
  write_raster(folder / "a.tif", {.width = 40, .height = 30}, [](std::int64_t x, std::int64_t y, int band) { return x * 2 + y + band; });
  LayerRequest request = request_for({folder / "a.tif"}, ChannelType::kColor);
  // 2 m texels from 500000, 5400000. West and north fall between grid lines; the south-eastern part of the
  // source lies outside.
  request.area = Area{499989.5, 5399960.0, 500060.0, 5400003.0};
  build(folder / "a.vts", request);
  auto reader = store::StoreReader::open(folder / "a.vts");
  const LayerInfo& layer = *reader->find_layer("color");
  EXPECT_EQ(layer.grid.origin_x, 499988.0);
  EXPECT_EQ(layer.grid.origin_y, 5400004.0);
  EXPECT_EQ(layer.data.width, 36);
  EXPECT_EQ(layer.data.height, 22);
  const Tiles tiles = tiles_of(folder / "a.vts", "color");
  EXPECT_EQ(layer.format, TexelFormat::kRgba8) << "north and west of the source nothing is known";
  EXPECT_EQ((texel_at<std::uint8_t, 4>(tiles, 5, layer.finest, 6, 2)), (std::array<std::uint8_t, 4>{0, 1, 2, 255}));
  EXPECT_EQ((texel_at<std::uint8_t, 4>(tiles, 5, layer.finest, 35, 21)), (std::array<std::uint8_t, 4>{29 * 2 + 19, 78, 79, 255}));
}

TEST(Area, SourcesOutsideAreLeftOutAndSaidSo) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 20, .height = 20};
  RasterSpec far = spec;
  far.transform.x0 += 1000.0;
  write_raster(folder / "here.tif", spec, [](auto, auto, int) { return 7.0; });
  write_raster(folder / "far.tif", far, [](auto, auto, int) { return 9.0; });
  LayerRequest request = request_for({folder / "here.tif", folder / "far.tif"}, ChannelType::kColor);
  request.area = Area{500000.0, 5399960.0, 500040.0, 5400000.0};
  const auto plan = plan_layer(request, std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  EXPECT_EQ(plan->info.data.width, 20);
  ASSERT_EQ(plan->warnings.size(), 1U);
  EXPECT_THAT(plan->warnings[0], testing::AllOf(HasSubstr("far.tif"), HasSubstr("outside")));

  request.area = Area{10.0, 5.0, 10.0, 6.0};
  EXPECT_EQ(plan_layer(request, std::nullopt, 1 << 20).error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace vt::pipeline
