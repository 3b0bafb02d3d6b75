// The whole runtime on a GL that only remembers.
#include "runtime/virtual_texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <thread>

#include "tests/runtime/count_allocations.h"
#include "tests/runtime/fake_gl.h"
#include "tests/runtime/test_store.h"

namespace vt::runtime {
namespace {

using test::FakeGl;
using test::noise_paint;
using test::PaintedSource;

constexpr Area kArea{.west = 0, .south = 0, .east = 1, .north = 1};

struct Rig {
  explicit Rig(Options options, int finest = 12)
      : layer(test::layer_info({.tile_exponent = 5, .finest = finest, .data = {}, .paint = {}, .skip = {}}, kArea)) {
    source = std::make_shared<PaintedSource>(TexelFormat::kRgb8, noise_paint(TexelFormat::kRgb8));
    auto opened = VirtualTexture::open(source, kArea, layer, std::move(options));
    EXPECT_TRUE(opened.has_value());
    texture = std::make_unique<VirtualTexture>(std::move(*opened));
  }
  void attach() {
    const auto attached = texture->attach(gl.host());
    ASSERT_TRUE(attached.has_value()) << attached.error().message;
  }
  void settle() {
    texture->update();
    while (!texture->settled()) {  // however busy the machine is
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      texture->update();
    }
  }
  // Until the loader has delivered its first tile; uploads nothing.
  void wait_for_the_loader() const {
    while (texture->loader_counters().tiles_read == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  // A draw: what is bound must be a whole tile with all its mips, and the one that the tile list names.
  void check_draw(const UvBox& box) {
    const StageSet set = texture->select(box);
    if (set.count == 0) return;
    texture->forget_bindings();
    texture->bind(set, {box.u_min, box.v_min});
    for (const VirtualTexture::TileState& tile : texture->tiles()) {
      if (tile.gl_texture != gl.bound) continue;
      ASSERT_TRUE(tile.shown);
      for (int mip = 0; mip < tile.mips; ++mip) {
        const FakeGl::Mip& content = gl.textures[gl.bound][mip];
        std::array<std::byte, 3> want{};
        const std::int64_t edge = tile.texels >> mip;
        for (std::int64_t y = 0; y < edge; ++y)
          for (std::int64_t x = 0; x < edge; ++x) {
            noise_paint(TexelFormat::kRgb8)(Level{static_cast<std::uint8_t>(tile.level.value - mip)}, (tile.x >> mip) + x,
                                            (tile.y >> mip) + y, want.data());
            ASSERT_EQ(std::memcmp(content.texels.data() + (y * edge + x) * 3, want.data(), 3), 0)
                << "level " << int{tile.level.value} << " mip " << mip << " texel " << x << ", " << y;
          }
      }
      return;
    }
    FAIL() << "a texture that no tile shows is bound";
  }

  FakeGl gl;
  LayerInfo layer;
  std::shared_ptr<PaintedSource> source;
  std::unique_ptr<VirtualTexture> texture;  // last: its loader reads the source
};

Options small_options(int tiles_per_side = 1) {
  Options options;
  options.layout.tile_exponent = 6;
  options.layout.tiles_per_side = tiles_per_side;
  return options;
}

TEST(VirtualTexture, UsesNothingBeyondOpenGl12) {
  Rig rig(small_options());
  rig.attach();
  rig.settle();
  rig.check_draw({0.5, 0.5, 0.5001, 0.5001});
  EXPECT_TRUE(rig.gl.refused.empty()) << *rig.gl.refused.begin();
  EXPECT_FALSE(rig.gl.bad_upload);
}

TEST(VirtualTexture, PutsGlStateBack) {
  Rig rig(small_options());
  rig.gl.bound = 4711;
  rig.attach();
  rig.settle();
  EXPECT_EQ(rig.gl.bound, 4711U);
  EXPECT_EQ(rig.gl.pixel_store[gl12::GL_UNPACK_ALIGNMENT], 4);
  EXPECT_EQ(rig.gl.pixel_store[gl12::GL_UNPACK_ROW_LENGTH], 7);
  rig.texture->bind(rig.texture->select({0.5, 0.5, 0.5, 0.5}));
  EXPECT_EQ(rig.gl.matrix_mode, 0x1700);
}

TEST(VirtualTexture, DetachLeavesNoTexture) {
  Rig rig(small_options(2));
  rig.attach();
  rig.settle();
  EXPECT_FALSE(rig.gl.textures.empty());
  rig.texture->detach();
  EXPECT_TRUE(rig.gl.textures.empty());
  // And it can begin anew.
  rig.attach();
  rig.settle();
  rig.check_draw({0.5, 0.5, 0.5001, 0.5001});
}

TEST(VirtualTexture, UploadsNeverExceedTheBudgetWhateverItIs) {
  for (const std::size_t budget : {1UL, 3UL, 100UL, 5000UL, 20000UL, 1UL << 20}) {
    Options options = small_options();
    options.upload_budget_bytes = budget;
    Rig rig(options, 6);
    rig.attach();
    rig.texture->update();  // asks the loader
    rig.wait_for_the_loader();
    // Small budgets need longer than a test has; 5000 bytes a frame do not.
    for (int frame = 0; (budget >= 5000 || frame < 300) && !rig.texture->settled(); ++frame) {
      const std::size_t before = rig.gl.uploaded_bytes;
      const FrameStats stats = rig.texture->update();
      ASSERT_EQ(rig.gl.uploaded_bytes - before, stats.upload_bytes);
      ASSERT_LE(stats.upload_bytes, budget);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
    EXPECT_EQ(rig.gl.uploaded_bytes > 0, budget >= 3) << "three bytes are a texel";
    EXPECT_TRUE(budget < 5000 || rig.texture->settled());
  }
}

TEST(VirtualTexture, BudgetZeroStopsUploadsAndABudgetGivenLaterResumesThem) {
  Options options = small_options();
  options.upload_budget_bytes = 0;
  Rig rig(options, 6);
  rig.attach();
  for (int i = 0; i < 50; ++i) rig.texture->update();
  EXPECT_EQ(rig.gl.uploaded_bytes, 0U);
  rig.texture->set_upload_budget(1 << 20);
  rig.settle();
}

TEST(VirtualTexture, NoHalfLoadedTileIsEverBound) {
  Options options = small_options(2);
  options.upload_budget_bytes = 7000;  // a tile with mips is about 16 kB: it takes several frames
  Rig rig(options, 8);
  rig.attach();
  std::mt19937 random(41);
  std::uniform_real_distribution<double> step(-0.02, 0.02);
  Point2 center{0.5, 0.5};
  for (int frame = 0; frame < 400; ++frame) {
    center = {std::clamp(center.x + step(random), 0.0, 1.0), std::clamp(center.y + step(random), 0.0, 1.0)};
    rig.texture->set_center(center);
    rig.texture->update();
    rig.check_draw({center.x, center.y, center.x + 0.002, center.y + 0.002});
    if (HasFatalFailure()) return;
    if (frame % 8 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
}

TEST(VirtualTexture, FromTheFirstTileOnThereIsNeverAHole) {
  Options options = small_options();
  options.upload_budget_bytes = 4000;
  Rig rig(options, 10);
  rig.source->during_read = [] { std::this_thread::sleep_for(std::chrono::microseconds(300)); };  // so that there is much to catch
  rig.attach();
  bool something = false;
  std::mt19937 random(42);
  std::uniform_real_distribution<double> anywhere(0.0, 0.99);
  int coarsest_first = -1;
  for (int frame = 0; frame < 2000; ++frame) {
    if (frame % 100 == 99) rig.texture->set_center({anywhere(random), anywhere(random)});
    const FrameStats stats = rig.texture->update();
    if (stats.pages_completed > 0 && coarsest_first < 0)
      for (const auto& tile : rig.texture->tiles())
        if (tile.shown) coarsest_first = tile.level.value;
    const Point2 at{anywhere(random), anywhere(random)};
    const StageSet set = rig.texture->select({at.x, at.y, at.x + 0.01, at.y + 0.01});
    something = something || set.count > 0;
    ASSERT_TRUE(!something || set.covers) << "frame " << frame;
    if (!something) frame = -1;  // until there is something, frames do not count
    if (frame < 200) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  EXPECT_TRUE(something);
  EXPECT_EQ(coarsest_first, 1) << "the tile over everything comes first";
}

TEST(VirtualTexture, TheDrawThreadNeverReads) {
  Rig rig(small_options());
  rig.attach();
  rig.settle();
  EXPECT_GT(rig.source->reads, 0);
  EXPECT_NE(rig.source->last_thread.load(), std::this_thread::get_id());
}

TEST(VirtualTexture, ASettledFrameAllocatesNothingAndNeitherDoesAMovingOne) {
  Options options = small_options(3);
  Rig rig(options, 8);
  rig.attach();
  rig.settle();
  rig.texture->set_center({0.3, 0.6});
  rig.settle();
  const std::uint64_t before = test::allocations_of_this_thread();
  for (int frame = 0; frame < 500; ++frame) {
    rig.texture->set_center({0.3 + frame * 0.001, 0.6});
    rig.texture->update();
    const StageSet set = rig.texture->select({0.3, 0.6, 0.301, 0.601});
    rig.texture->bind(set, {0.3, 0.6});
  }
  EXPECT_EQ(test::allocations_of_this_thread(), before);
}

TEST(VirtualTexture, ACenterThatSwingsOverAGridLineLoadsOnce) {
  Rig rig(small_options(), 8);
  rig.attach();
  const double texel = 1.0 / 8192;
  const double line = 0.5 + 16 * texel;
  rig.texture->set_center({line, 0.5});
  rig.settle();
  const int reads = rig.source->reads;
  for (int frame = 0; frame < 200; ++frame) {
    rig.texture->set_center({line + (frame % 2 == 0 ? 6 : -6) * texel, 0.5});
    rig.texture->update();
  }
  rig.settle();
  EXPECT_LE(rig.source->reads, reads) << "the center moved by less than the hysteresis";
}

TEST(VirtualTexture, TeleportsSettleAndShowTheRightPlace) {
  Rig rig(small_options(2), 10);
  rig.attach();
  std::mt19937 random(43);
  std::uniform_real_distribution<double> anywhere(0.01, 0.98);
  for (int jump = 0; jump < 30; ++jump) {
    const Point2 center{anywhere(random), anywhere(random)};
    rig.texture->set_center(center);
    if (jump % 3 != 0) {  // often it jumps on before anything has come
      rig.texture->update();
      continue;
    }
    rig.settle();
    const StageSet set = rig.texture->select({center.x, center.y, center.x + 1e-6, center.y + 1e-6});
    ASSERT_EQ(set.count, 1);
    EXPECT_EQ(rig.texture->tiles()[static_cast<std::size_t>(set.slots[0])].level, rig.layer.finest);
    rig.check_draw({center.x, center.y, center.x + 1e-6, center.y + 1e-6});
  }
}

TEST(VirtualTexture, StrangeCentersAreIgnoredOrClamped) {
  Rig rig(small_options(), 8);
  rig.attach();
  rig.settle();
  const int reads = rig.source->reads;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Point2 strange : {Point2{nan, 0.5}, {0.5, nan}, {infinity, 0.5}, {0.5, -infinity}}) {
    rig.texture->set_center(strange);
    rig.texture->set_level_center(rig.layer.finest, strange);
    rig.texture->update();
  }
  rig.settle();
  EXPECT_EQ(rig.source->reads, reads);
  for (const Point2 outside : {Point2{-3.0, 0.5}, {1e300, -1e300}, {7.0, 9.0}}) {
    rig.texture->set_center(outside);
    rig.settle();
    for (const auto& tile : rig.texture->tiles()) {
      EXPECT_GE(tile.x, 0);
      EXPECT_LE(tile.x + tile.texels, std::int64_t{1} << (5 + tile.level.value));
    }
  }
}

TEST(VirtualTexture, CentersMayBeSetFromAnyThread) {
  Rig rig(small_options(2), 10);
  rig.attach();
  std::vector<std::jthread> setters;
  for (int k = 0; k < 3; ++k)
    setters.emplace_back([&rig, k](std::stop_token stop) {
      std::mt19937 random(static_cast<unsigned>(50 + k));
      std::uniform_real_distribution<double> anywhere(0.0, 1.0);
      while (!stop.stop_requested()) {
        rig.texture->set_center({anywhere(random), anywhere(random)});
        rig.texture->set_level_center(Level{7}, {anywhere(random), anywhere(random)});
        rig.texture->follow_center(Level{7});
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    });
  for (int frame = 0; frame < 500; ++frame) {
    rig.texture->update();
    rig.check_draw({0.4, 0.4, 0.41, 0.41});
    if (HasFatalFailure()) return;
  }
  setters.clear();
  rig.settle();
}

TEST(VirtualTexture, ALevelMayHaveACenterOfItsOwn) {
  Rig rig(small_options(), 8);
  rig.attach();
  rig.texture->set_center({0.25, 0.25});
  rig.texture->set_level_center(Level{8}, {0.75, 0.75});
  rig.settle();
  const auto level_at = [&](double u) {
    return rig.texture->tiles()[static_cast<std::size_t>(rig.texture->select({u, u, u, u}).slots[0])].level;
  };
  EXPECT_EQ(level_at(0.75), Level{8});
  EXPECT_EQ(level_at(0.25), Level{7});
  rig.texture->follow_center(Level{8});
  rig.settle();
  EXPECT_EQ(level_at(0.25), Level{8});
}

TEST(VirtualTexture, ATileThatCannotBeReadIsReportedAndTheCoarserOneServes) {
  Rig rig(small_options(), 8);
  rig.source->fail_level = 8;
  rig.attach();
  rig.settle();
  EXPECT_EQ(rig.texture->last_error(), "painted to fail");
  const StageSet set = rig.texture->select({0.5, 0.5, 0.5001, 0.5001});
  ASSERT_TRUE(set.covers);
  EXPECT_EQ(rig.texture->tiles()[static_cast<std::size_t>(set.slots[0])].level, Level{7});
}

TEST(VirtualTexture, BindsAreCountedAndAreTheDistinctTilesWhenSorted) {
  Rig rig(small_options(4), 8);
  rig.attach();
  rig.settle();
  std::mt19937 random(44);
  std::uniform_real_distribution<double> near(0.48, 0.52);
  std::vector<StageSet> draws;
  std::set<int> distinct;
  for (int i = 0; i < 300; ++i) {
    const Point2 at{near(random), near(random)};
    draws.push_back(rig.texture->select({at.x, at.y, at.x + 1e-4, at.y + 1e-4}));
    distinct.insert(draws.back().slots[0]);
  }
  std::vector<std::uint32_t> order(draws.size());
  sort_by_tile(draws, order);
  rig.texture->update();
  for (const std::uint32_t i : order) rig.texture->bind(draws[i]);
  EXPECT_EQ(rig.texture->update().binds, static_cast<int>(distinct.size()));
  EXPECT_GT(distinct.size(), 4U);
}

TEST(VirtualTexture, TextureMemoryIsWhatWasPredicted) {
  Options options = small_options(3);
  Rig rig(options, 8);
  rig.attach();
  std::uint64_t bytes = 0;
  for (const auto& [name, mips] : rig.gl.textures)
    for (const auto& [mip, content] : mips) bytes += content.texels.size();
  EXPECT_EQ(texture_bytes(rig.layer, options.layout).value(), bytes);
  EXPECT_EQ(rig.texture->texture_bytes(), bytes);
}

TEST(VirtualTexture, TheLayoutForABudgetFitsItAndUsesIt) {
  const LayerInfo layer = test::layer_info({.tile_exponent = 8, .finest = 13, .data = {}, .paint = {}, .skip = {}}, kArea);
  std::int64_t last = 0;
  for (const std::uint64_t mib : {1ULL, 4ULL, 16ULL, 64ULL, 256ULL, 1024ULL}) {
    const auto layout = layout_for_budget(layer, mib << 20);
    if (!layout) continue;
    EXPECT_LE(texture_bytes(layer, *layout).value(), mib << 20);
    const std::int64_t texels = std::int64_t{layout->tiles_per_side} << layout->tile_exponent;
    EXPECT_GE(texels, last);
    last = texels;
  }
  EXPECT_GE(last, 2048);
  EXPECT_FALSE(layout_for_budget(layer, 1000));
}

TEST(VirtualTexture, MovingTheCenterDoesNotMoveTheTexture) {
  // Row 14: what a fixed place shows is the same to the last bit wherever the center is, as long as its level
  // is shown.
  Rig rig(small_options(), 10);
  rig.attach();
  const Point2 place{0.5003, 0.4996};
  std::set<std::int64_t> texels;
  for (int i = 0; i < 12; ++i) {
    rig.texture->set_center({place.x + (i - 6) * 4.0 / 32768, place.y});
    rig.settle();
    const StageSet set = rig.texture->select({place.x, place.y, place.x, place.y});
    const auto tile = rig.texture->tiles()[static_cast<std::size_t>(set.slots[0])];
    if (tile.level != rig.layer.finest) continue;
    rig.texture->bind(set, place);
    // Where the matrix puts the place, in texels of the level, must not depend on the tile.
    const double x = rig.gl.matrix[12] * static_cast<double>(tile.texels) + static_cast<double>(tile.x);
    EXPECT_NEAR(x, place.x * 32768, 1e-9);
    texels.insert(std::llround(x * 1e6));
  }
  EXPECT_EQ(texels.size(), 1U);
}

TEST(VirtualTexture, ErrorsSayWhatIsMissing) {
  Rig rig(small_options());
  const auto no_getproc = rig.texture->attach({});
  ASSERT_FALSE(no_getproc.has_value());
  EXPECT_NE(no_getproc.error().message.find("getproc"), std::string::npos);
  GlHost shader = rig.gl.host();
  shader.path = Path::kShader;
  const auto too_old = rig.texture->attach(shader);
  ASSERT_FALSE(too_old.has_value());
  EXPECT_NE(too_old.error().message.find("2.1"), std::string::npos);
  EXPECT_TRUE(rig.gl.textures.empty());

  auto heights = VirtualTexture::open(
      std::make_shared<PaintedSource>(TexelFormat::kR32Float, noise_paint(TexelFormat::kR32Float)), kArea,
      test::layer_info({.format = TexelFormat::kR32Float, .tile_exponent = 5, .finest = 3, .data = {}, .paint = {}, .skip = {}}, kArea),
      small_options());
  ASSERT_TRUE(heights.has_value());
  const auto floats = heights->attach(rig.gl.host());
  ASSERT_FALSE(floats.has_value());
  EXPECT_NE(floats.error().message.find("shader path"), std::string::npos);

  auto hashes = VirtualTexture::open(
      std::make_shared<PaintedSource>(TexelFormat::kHash128, noise_paint(TexelFormat::kHash128)), kArea,
      test::layer_info({.format = TexelFormat::kHash128, .tile_exponent = 5, .finest = 3, .data = {}, .paint = {}, .skip = {}}, kArea),
      small_options());
  ASSERT_TRUE(hashes.has_value());
  const auto no_texture = hashes->attach(rig.gl.host());
  ASSERT_FALSE(no_texture.has_value());
  EXPECT_EQ(no_texture.error().code, ErrorCode::kUnsupported);
}

TEST(VirtualTexture, OpensAStoreAndNamesItsLayersWhenTheWantedOneIsMissing) {
  test::TempFolder folder;
  const auto reader =
      test::make_store(folder / "s.vts", {{.name = "summer", .tile_exponent = 5, .finest = 2, .data = {}, .paint = {}, .skip = {}},
                                          {.name = "winter", .tile_exponent = 5, .finest = 1, .data = {}, .paint = {}, .skip = {}}});
  ASSERT_TRUE(reader.has_value()) << reader.error().message;
  const auto first = VirtualTexture::open(folder / "s.vts");
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->layer().name, "summer");
  Options options;
  options.layer = "winter";
  EXPECT_EQ(VirtualTexture::open(*reader, options)->layer().name, "winter");
  options.layer = "autumn";
  const auto missing = VirtualTexture::open(*reader, options);
  ASSERT_FALSE(missing.has_value());
  EXPECT_NE(missing.error().message.find("summer, winter"), std::string::npos);
}

// The golden store's layers "aspect" and "later" have unknown channels, "strange" an unknown texel format.
TEST(VirtualTexture, TakesLayersOfUnknownChannelsAndNamesAnUnknownFormat) {
  const auto golden = std::filesystem::path(VT_SOURCE_DIR) / "tests/golden/unknown-numbers.vts";
  EXPECT_EQ(VirtualTexture::open(golden)->layer().name, "color");
  Options options;
  for (const std::string layer : {"aspect", "later"}) {
    options.layer = layer;
    const auto opened = VirtualTexture::open(golden, options);
    ASSERT_TRUE(opened.has_value()) << opened.error().message;
    EXPECT_EQ(opened->layer().name, layer);
  }
  options.layer = "strange";
  const auto refused = VirtualTexture::open(golden, options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(refused.error().message.find("layer strange: its texel format has number 999"), std::string::npos);
}

}  // namespace
}  // namespace vt::runtime
