// Sources change under a finished store: only what depends on the change is built again, and nothing in the
// result tells.
#include <gtest/gtest.h>

#include <fstream>

#include "builder/pipeline/plan/work_map.h"
#include "store/validate.h"
#include "tests/pipeline/small_builds.h"

namespace vt::pipeline {
namespace {

// 20 x 15 blocks of 64 texels, so that most of the layer is far from any one change.
constexpr RasterSpec kRaster{.width = 1280, .height = 960};
constexpr int kBlockLevels = 1;

double original(std::int64_t x, std::int64_t y, int band) { return hash_noise(x, y, band) % 256; }

BuildOptions updating() { return {.threads = 2, .block_levels = kBlockLevels, .update = true, .with_stats = true}; }

class Update : public testing::Test {
 protected:
  void SetUp() override {
    write_raster(folder_ / "input.tif", kRaster, original);
    build(folder_ / "store.vts", request(), {.threads = 2, .block_levels = kBlockLevels});
  }

  [[nodiscard]] LayerRequest request() const { return request_for({folder_ / "input.tif"}, ChannelType::kColor); }
  [[nodiscard]] std::uintmax_t store_bytes() const { return std::filesystem::file_size(folder_ / "store.vts"); }

  // The updated store holds what a new build of the same sources holds.
  void expect_as_built_anew(const LayerRequest& wanted) const {
    const auto anew = folder_ / "anew.vts";
    std::filesystem::remove(anew);
    build(anew, wanted, {.threads = 1, .block_levels = kBlockLevels});
    EXPECT_TRUE(tiles_of(folder_ / "store.vts", "color") == tiles_of(anew, "color"));
    EXPECT_TRUE(tiles_of(folder_ / "store.vts", "color/carry") == tiles_of(anew, "color/carry"));
    const auto report = store::validate(folder_ / "store.vts");
    ASSERT_TRUE(report.has_value());
    EXPECT_TRUE(report->ok()) << report->findings.front().place << ": " << report->findings.front().sentence;
    EXPECT_EQ(store::StoreReader::open(folder_ / "store.vts")->find_layer("color")->state, LayerState::kComplete);
  }

  test::TempFolder folder_;
};

TEST_F(Update, NothingChangedMeansNothingIsWritten) {
  const auto before = store_bytes();
  // A copy under another date: only the content counts.
  std::filesystem::last_write_time(folder_ / "input.tif", std::filesystem::file_time_type::clock::now() + std::chrono::hours(3));
  const BuildReport report = build(folder_ / "store.vts", request(), updating());
  EXPECT_TRUE(report.was_complete);
  EXPECT_EQ(report.blocks_checked, 20 * 15);
  EXPECT_EQ(report.blocks_changed, 0);
  EXPECT_EQ(store_bytes(), before);
}

TEST_F(Update, AChangedTexelCostsItsBlockAndItsAncestors) {
  // In the middle of block (10, 7), out of reach of its neighbours' filters on the base level.
  write_raster(folder_ / "input.tif", kRaster, [](std::int64_t x, std::int64_t y, int band) {
    return x == 672 && y == 480 ? 255.0 - original(x, y, band) : original(x, y, band);
  });
  const BuildReport report = build(folder_ / "store.vts", request(), updating());
  EXPECT_FALSE(report.was_complete);
  EXPECT_EQ(report.blocks_checked, 20 * 15);
  // The source's tiles are 64 texels, as are the blocks, and a block also reads an apron: at most 3 x 3
  // blocks see the changed tile.
  EXPECT_GE(report.blocks_changed, 1);
  EXPECT_LE(report.blocks_changed, 9);
  // At most a few of the ancestors' tiles a level can differ: the kernel reaches 6 texels.
  const LayerInfo info = *store::StoreReader::open(folder_ / "store.vts")->find_layer("color");
  EXPECT_GE(report.tile_counts.written, 1);
  EXPECT_LE(report.tile_counts.written, 4 * (info.finest.value + 1));
  EXPECT_EQ(report.tile_counts.removed, 0);
  EXPECT_LT(report.tile_counts.written + report.tile_counts.unchanged, static_cast<std::int64_t>(info.tiles) / 4);
  EXPECT_GT(report.stages.of(Stage::kCheck), 0.0);
  expect_as_built_anew(request());
}

// The larger the change, the larger the work, up to everything.
TEST_F(Update, WorkIsInProportionToTheChange) {
  std::int64_t last = 0;
  for (const int edge : {64, 256, 640, 1280}) {
    write_raster(folder_ / "input.tif", kRaster, [edge](std::int64_t x, std::int64_t y, int band) {
      return x < edge && y < edge ? original(x + edge, y, band) : original(x, y, band);
    });
    const BuildReport report = build(folder_ / "store.vts", request(), updating());
    const std::int64_t blocks = ((edge + 63) / 64 + 1) * (std::min(edge, 960) / 64 + 1);
    EXPECT_LE(report.blocks_changed, blocks) << edge;
    EXPECT_GT(report.tile_counts.written, last) << edge;
    last = report.tile_counts.written;
  }
  expect_as_built_anew(request());
}

TEST_F(Update, ANewSourceOnTopChangesOnlyWhatItCovers) {
  RasterSpec patch{.width = 100, .height = 80};
  patch.transform.x0 += 300 * 2.0;
  patch.transform.y0 -= 200 * 2.0;
  write_raster(folder_ / "patch.tif", patch, [](std::int64_t x, std::int64_t y, int) { return static_cast<double>((x + y) % 250); });
  const LayerRequest both = request_for({folder_ / "input.tif", folder_ / "patch.tif"}, ChannelType::kColor);

  // Without being told to update, another list of sources is refused.
  const auto frame = existing_frame(folder_ / "store.vts");
  const auto plan = plan_layer(both, *frame, std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value()) << plan.error().message;
  {
    auto writer = open_or_create(folder_ / "store.vts", plan->crs, plan->extent());
    const auto refused = build_layer(*writer, *plan, {});
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().code, ErrorCode::kExists);
    EXPECT_NE(refused.error().message.find("`update`"), std::string::npos) << refused.error().message;
  }

  const BuildReport added = build(folder_ / "store.vts", both, updating());
  EXPECT_GE(added.blocks_changed, 2 * 2);
  EXPECT_LE(added.blocks_changed, 5 * 4);
  expect_as_built_anew(both);
  const BuildReport taken_away = build(folder_ / "store.vts", request(), updating());
  EXPECT_EQ(taken_away.blocks_changed, added.blocks_changed);
  expect_as_built_anew(request());
}

TEST_F(Update, TilesOfASourceThatIsGoneGo) {
  // Far to the east, with nothing between.
  RasterSpec island{.width = 64, .height = 64};
  island.transform.x0 += 5000 * 2.0;
  write_raster(folder_ / "island.tif", island, original);
  LayerRequest both = request_for({folder_ / "input.tif", folder_ / "island.tif"}, ChannelType::kColor);
  both.name = "isles";
  both.format = TexelFormat::kRgb8;  // coverage would make tiles of nothing but what is clear
  build(folder_ / "isles.vts", both, {.threads = 2, .block_levels = kBlockLevels});
  const Tiles before = tiles_of(folder_ / "isles.vts", "isles");

  // A source of the same place and size without data.
  RasterSpec sunk = island;
  sunk.nodata = 7.0;
  write_raster(folder_ / "island.tif", sunk, [](std::int64_t, std::int64_t, int) { return 7.0; });
  const BuildReport report = build(folder_ / "isles.vts", both, updating());
  EXPECT_GT(report.tile_counts.removed, 0);
  build(folder_ / "anew.vts", both, {.threads = 2, .block_levels = kBlockLevels});
  const Tiles after = tiles_of(folder_ / "isles.vts", "isles");
  EXPECT_LT(after.size(), before.size());
  EXPECT_TRUE(after == tiles_of(folder_ / "anew.vts", "isles"));
}

// The usual format depends on whether sources cover the layer, but a layer that is there keeps its own.
TEST_F(Update, AFileThatGoesLeavesTheFormatAsItIs) {
  RasterSpec east{.width = 64, .height = 64};
  east.transform.x0 += 64 * east.transform.x_column;
  write_raster(folder_ / "west.tif", {.width = 64, .height = 64}, original);
  write_raster(folder_ / "east.tif", east, original);
  LayerRequest both = request_for({folder_ / "west.tif", folder_ / "east.tif"}, ChannelType::kColor);
  both.area = Area{east.transform.x0 - 64 * east.transform.x_column, east.transform.y0 - 64 * east.transform.x_column,
                   east.transform.x0 + 64 * east.transform.x_column, east.transform.y0};
  build(folder_ / "pair.vts", both, {.threads = 2, .block_levels = kBlockLevels});
  both.sources.pop_back();
  {  // An update that is stopped and run again is the same update.
    const auto plan = plan_layer(both, *existing_frame(folder_ / "pair.vts"), std::size_t{8} << 20);
    ASSERT_TRUE(plan.has_value()) << plan.error().message;
    std::atomic<bool> cancel{false};
    BuildOptions stopping = updating();
    stopping.cancel = &cancel;
    stopping.progress = [&](std::uint64_t, std::uint64_t) { cancel = true; };
    auto writer = open_or_create(folder_ / "pair.vts", plan->crs, plan->extent());
    ASSERT_EQ(build_layer(*writer, *plan, stopping).error().code, ErrorCode::kCancelled);
  }
  ASSERT_EQ(store::StoreReader::open(folder_ / "pair.vts")->find_layer("color")->state, LayerState::kBuilding);
  const BuildReport report = build(folder_ / "pair.vts", both, updating());
  EXPECT_GE(report.blocks_changed, 1);
  EXPECT_EQ(store::StoreReader::open(folder_ / "pair.vts")->find_layer("color")->format, TexelFormat::kRgb8);
  LayerRequest opaque = both;
  opaque.format = TexelFormat::kRgb8;
  build(folder_ / "west.vts", opaque, {.threads = 1, .block_levels = kBlockLevels});
  EXPECT_TRUE(tiles_of(folder_ / "pair.vts", "color") == tiles_of(folder_ / "west.vts", "color"));
  const auto alone = plan_layer(both, std::nullopt, std::size_t{8} << 20);
  ASSERT_TRUE(alone.has_value()) << alone.error().message;
  EXPECT_EQ(alone->info.format, TexelFormat::kRgba8) << "where there is no layer yet";
}

// An update that is stopped leaves an unfinished layer, and going on completes it.
TEST_F(Update, GoesOnWhereItWasStopped) {
  write_raster(folder_ / "input.tif", kRaster, [](std::int64_t x, std::int64_t y, int band) { return original(x + 1, y, band); });
  auto plan = plan_layer(request(), *existing_frame(folder_ / "store.vts"), std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value());
  std::atomic<bool> cancel{false};
  BuildOptions options = updating();
  options.cancel = &cancel;
  options.progress = [&](std::uint64_t done, std::uint64_t total) { cancel = cancel || done * 3 > total; };
  {
    auto writer = open_or_create(folder_ / "store.vts", plan->crs, plan->extent());
    const auto stopped = build_layer(*writer, *plan, options);
    ASSERT_FALSE(stopped.has_value());
    ASSERT_EQ(stopped.error().code, ErrorCode::kCancelled);
  }
  EXPECT_EQ(store::StoreReader::open(folder_ / "store.vts")->find_layer("color")->state, LayerState::kBuilding);
  // The plain command goes on, since the sources are those of the update.
  const BuildReport rest = build(folder_ / "store.vts", request(), {.threads = 2});
  EXPECT_GT(rest.blocks_resumed, 0);
  EXPECT_GT(rest.blocks_built, 0);
  expect_as_built_anew(request());
}

TEST_F(Update, AnotherSettingIsNoUpdate) {
  LayerRequest other = request();
  other.kernel = "box";
  const auto plan = plan_layer(other, *existing_frame(folder_ / "store.vts"), std::size_t{8} << 20);
  auto writer = open_or_create(folder_ / "store.vts", plan->crs, plan->extent());
  const auto refused = build_layer(*writer, *plan, updating());
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kExists);
}

// Parts, carry of many planes and quality are updated with the layer.
TEST(UpdateOfParts, GivesWhatANewBuildGives) {
  const test::TempFolder folder;
  const RasterSpec spec{.width = 300, .height = 200, .bands = 1};
  const auto cover = [](std::int64_t x, std::int64_t y, int) { return static_cast<double>((x / 7 + y / 9) % 5 + hash_noise(x, y, 0) % 2); };
  LayerRequest request = request_for({folder / "cover.tif"}, ChannelType::kMaterial);
  request.options["mixture"] = "3";
  write_raster(folder / "cover.tif", spec, cover);
  build(folder / "store.vts", request, {.threads = 2, .block_levels = 1});
  write_raster(folder / "cover.tif", spec,
               [&](std::int64_t x, std::int64_t y, int band) { return x / 20 == 5 && y / 20 == 4 ? 9.0 : cover(x, y, band); });
  const BuildReport report = build(folder / "store.vts", request, {.threads = 2, .update = true});
  EXPECT_GE(report.blocks_changed, 1);
  build(folder / "anew.vts", request, {.threads = 1, .block_levels = 1});
  for (const char* name : {"material", "material/classes", "material/weights", "material/carry", "material/quality"})
    EXPECT_TRUE(tiles_of(folder / "store.vts", name) == tiles_of(folder / "anew.vts", name)) << name;
  const auto quality = [&](const char* store) {
    const std::string metadata = store::StoreReader::open(folder / store)->find_layer("material")->metadata_json;
    return metadata.substr(metadata.find("\"quality\""));
  };
  EXPECT_EQ(quality("store.vts"), quality("anew.vts"));
}

// What codes mean may follow from the first source. Another one cannot give them another meaning in the
// blocks that change.
TEST(UpdateOfParts, CodesKeepTheirMeaning) {
  const test::TempFolder folder;
  const auto height = [](std::int64_t x, std::int64_t, int) { return static_cast<double>(x); };
  LayerRequest request = request_for({folder / "heights.tif"}, ChannelType::kElevation);
  request.format = TexelFormat::kR16;
  write_raster(folder / "heights.tif", {.width = 64, .height = 64, .bands = 1, .type = SampleType::kInt16}, height);
  build(folder / "store.vts", request);
  write_raster(folder / "heights.tif", {.width = 64, .height = 64, .bands = 1, .type = SampleType::kUint16}, height);
  auto plan = plan_layer(request, std::nullopt, std::size_t{8} << 20);
  ASSERT_TRUE(plan.has_value());
  auto writer = open_or_create(folder / "store.vts", plan->crs, plan->extent());
  ASSERT_TRUE(writer.has_value());
  const auto report = build_layer(*writer, *plan, {.update = true});
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().code, ErrorCode::kExists);
}

TEST(UpdateOfParts, SourcesThatMakeOtherTexelsAreNoLayer) {
  const test::TempFolder folder;
  const auto angle = [](std::int64_t, std::int64_t, int) { return 0.1; };
  write_raster(folder / "two.tif", {.width = 64, .height = 64, .bands = 2, .type = SampleType::kFloat32}, angle);
  write_raster(folder / "four.tif", {.width = 64, .height = 64, .bands = 4, .type = SampleType::kFloat32}, angle);
  const auto plan =
      plan_layer(request_for({folder / "two.tif", folder / "four.tif"}, ChannelType::kHorizon), std::nullopt, std::size_t{8} << 20);
  ASSERT_FALSE(plan.has_value());
  EXPECT_EQ(plan.error().code, ErrorCode::kInvalidData);
  EXPECT_NE(plan.error().message.find("four.tif"), std::string::npos);
  EXPECT_NE(plan.error().message.find("two.tif"), std::string::npos);
}

TEST(WorkMap, FindsTheBlocksUnderSourcesWithoutLookingAtAllOthers) {
  const test::TempFolder folder;
  RasterSpec spec{.width = 50, .height = 40};
  write_raster(folder / "a.tif", spec, original);
  spec.transform.x0 += 4000 * 2.0;
  spec.transform.y0 -= 3000 * 2.0;
  write_raster(folder / "b.tif", spec, original);
  const auto plan = plan_layer(request_for({folder / "a.tif", folder / "b.tif"}, ChannelType::kColor), std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value());
  const WorkMap work(*plan, 1);
  for (std::size_t tier = 0; tier < work.tiers().size(); ++tier) {
    std::vector<std::int64_t> wanted;
    for (std::int64_t i = 0; i < work.tiers()[tier].blocks(); ++i)
      if (work.is_touched(tier, i)) wanted.push_back(i);
    EXPECT_EQ(work.touched(tier), wanted) << tier;
  }
  EXPECT_LT(work.touched(0).size(), 20U);
  EXPECT_GT(work.tiers()[0].blocks(), 2000);
}

// A block depends on another exactly when its texels and apron meet the other's carry tile.
TEST(WorkMap, DependentsAreTheBlocksThatReadTheCarry) {
  const test::TempFolder folder;
  write_raster(folder / "a.tif", {.width = 700, .height = 500}, original);
  const auto plan = plan_layer(request_for({folder / "a.tif"}, ChannelType::kColor), std::nullopt, 1 << 20);
  ASSERT_TRUE(plan.has_value());
  const WorkMap work(*plan, 1);
  for (std::size_t tier = 0; tier + 1 < work.tiers().size(); ++tier)
    for (std::int64_t i = 0; i < work.tiers()[tier].blocks(); ++i) {
      std::vector<std::int64_t> wanted;
      const TexelRect carry = rect_of(work.tiers()[tier].carry_tile(i), plan->info.tile_exponent);
      for (std::int64_t j = 0; j < work.tiers()[tier + 1].blocks(); ++j)
        if (!intersect(work.active(tier + 1, j), carry).empty()) wanted.push_back(j);
      EXPECT_EQ(work.dependents(tier, i), wanted) << tier << " " << i;
    }
}

}  // namespace
}  // namespace vt::pipeline
