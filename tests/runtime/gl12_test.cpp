// The fixed-function path on a real OpenGL: what is drawn through the virtual texture is what an ordinary
// texture would show.
#include "tests/runtime/gl_fixture.h"

namespace vt::runtime {
namespace {

using test::compare;
using test::Difference;
using test::Frame;
using test::noise_paint;
using test::open_painted;
using test::painted;
using test::Painted;
using test::quad_views;
using test::QuadView;
using test::gl::GL_TEXTURE_2D;

class Gl12 : public test::GlTest {
 protected:
  void SetUp() override { open(tools::GlProfile::kCompatibility); }
  GlHost strict_host() {
    return {.getproc = test::StrictGetProc::getproc, .user = &strict_, .path = Path::kFixedFunction, .allow_extensions = false};
  }
  test::StrictGetProc strict_;
};

// 8-bit filter weights of the software rasterizer: a window by texture matrix differs from the whole texture
// by at most 2 on white noise.
constexpr int kWindowTolerance = 2;

TEST_F(Gl12, AQuadThroughTheVirtualTextureEqualsOneOrdinaryTexture) {
  const Painted p = painted(TexelFormat::kRgb8, 8, 3, noise_paint(TexelFormat::kRgb8));  // 2048 texels
  Options options;
  options.layout.tile_exponent = 9;
  VirtualTexture texture = open_painted(p, options);
  ASSERT_TRUE(texture.attach(strict_host()).has_value());
  texture.set_center({0.61, 0.37});
  settle(texture);
  const unsigned whole = ordinary_texture(p.paint, TexelFormat::kRgb8, p.layer.finest, 0, 0, 2048, 4);
  for (const QuadView& view : quad_views()) {
    const double half = view.texels / 2.0 / 2048;
    const Point2 low{0.61 - half, 0.37 - half};
    const Point2 high{0.61 + half, 0.37 + half};
    gl_.BindTexture(GL_TEXTURE_2D, whole);
    texture_matrix_identity();
    const Frame reference = draw_fixed(view, {low.x, 1.0 - low.y}, {high.x, 1.0 - high.y});

    const StageSet set = texture.select({low.x, low.y, high.x, high.y});
    ASSERT_EQ(set.count, 1);
    ASSERT_TRUE(set.covers);
    ASSERT_EQ(texture.tiles()[static_cast<std::size_t>(set.slots[0])].level, p.layer.finest)
        << "the test would prove nothing with a coarser tile";
    texture.forget_bindings();
    texture.bind(set, low);
    const Frame drawn = draw_fixed(view, {}, {high.x - low.x, high.y - low.y});
    EXPECT_GT(test::lit_pixels(drawn), 5000) << view.name;
    const Difference difference = compare(reference, drawn);
    EXPECT_LE(difference.largest, kWindowTolerance) << view.name << ": " << difference.pixels << " pixels differ";
  }
  texture.detach();
  gl_.DeleteTextures(1, &whole);
  EXPECT_TRUE(strict_.refused.empty()) << *strict_.refused.begin();
}

TEST_F(Gl12, AGigatexelWideTextureIsAsSharpAsASmallOne) {
  for (const int vt : {20, 24, 30}) {
    const Painted p = painted(TexelFormat::kRgb8, 8, vt - 8, noise_paint(TexelFormat::kRgb8));
    Options options;
    options.layout.tile_exponent = 9;
    VirtualTexture texture = open_painted(p, options);
    ASSERT_TRUE(texture.attach(strict_host()).has_value());
    // Near the far corner, and not on a dyadic place: those are exact by accident.
    const Point2 place{0.9271830771, 0.0613379123};
    texture.set_center(place);
    settle(texture);
    const double texel = std::ldexp(1.0, -vt);
    const UvBox box{place.x, place.y, place.x + 64 * texel, place.y + 64 * texel};
    const StageSet set = texture.select(box);
    ASSERT_EQ(set.count, 1);
    const auto tile = texture.tiles()[static_cast<std::size_t>(set.slots[0])];
    ASSERT_EQ(tile.level, p.layer.finest);
    const QuadView view = quad_views()[0];
    texture.bind(set, place);
    const Frame drawn = draw_fixed(view, {}, {64 * texel, 64 * texel});

    // The same texels as a texture of their own, with coordinates that are small by nature.
    const unsigned own = ordinary_texture(p.paint, TexelFormat::kRgb8, p.layer.finest, tile.x, tile.y, 512, tile.mips);
    texture_matrix_identity();
    const long double width = std::ldexp(1.0L, vt);
    const Point2 low{static_cast<double>((place.x * width - tile.x) / 512), static_cast<double>(((1.0L - place.y) * width - tile.y) / 512)};
    const Frame reference = draw_fixed(view, low, {low.x + 64.0 / 512, low.y - 64.0 / 512});
    EXPECT_LE(compare(reference, drawn).largest, kWindowTolerance) << "vt " << vt;
    texture.detach();
    gl_.DeleteTextures(1, &own);
  }
}

TEST_F(Gl12, WithoutExtensionsBc1IsDecodedAndNothingNewerIsAsked) {
  const auto paint = [](Level level, std::int64_t x, std::int64_t y, std::byte* block) {
    noise_paint(TexelFormat::kBc1)(level, x, y, block);
    block[1] |= std::byte{0x80};
    block[3] &= std::byte{0x7F};
  };
  const Painted p = painted(TexelFormat::kBc1, 8, 3, paint);
  VirtualTexture texture = open_painted(p, {});
  ASSERT_TRUE(texture.attach(strict_host()).has_value());
  settle(texture);
  EXPECT_TRUE(strict_.refused.empty());
  const StageSet set = texture.select({0.5, 0.5, 0.51, 0.51});
  texture.bind(set, {0.5, 0.5});
  EXPECT_GT(test::lit_pixels(draw_fixed(quad_views()[0], {}, {0.01, 0.01})), 100000);
  texture.detach();
}

TEST_F(Gl12, DrawingSortedBindsEachTileOnce) {
  const Painted p = painted(TexelFormat::kRgb8, 6, 6, noise_paint(TexelFormat::kRgb8));
  Options options;
  options.layout = {.tile_exponent = 6, .tiles_per_side = 4, .overrides = {}};
  VirtualTexture texture = open_painted(p, options);
  ASSERT_TRUE(texture.attach(strict_host()).has_value());
  settle(texture);
  std::vector<StageSet> draws;
  for (int i = 0; i < 64; ++i) {
    const double u = 0.48 + 0.005 * (i % 8);
    const double v = 0.48 + 0.005 * (i / 8);
    draws.push_back(texture.select({u, v, u + 0.004, v + 0.004}));
  }
  std::vector<std::uint32_t> order(draws.size());
  sort_by_tile(draws, order);
  std::set<int> distinct;
  for (const std::uint32_t i : order) {
    texture.bind(draws[i]);
    distinct.insert(draws[i].slots[0]);
  }
  EXPECT_EQ(texture.update().binds, static_cast<int>(distinct.size()));
  texture.detach();
}

TEST_F(Gl12, AFlightKeepsItsUploadBudgetAndItsPictureWhole) {
  const Painted p =
      painted(TexelFormat::kRgb8, 6, 8, [](Level, std::int64_t, std::int64_t, std::byte* t) { t[0] = t[1] = t[2] = std::byte{200}; });
  Options options;
  options.layout = {.tile_exponent = 7, .tiles_per_side = 2, .overrides = {}};
  options.upload_budget_bytes = 20000;
  VirtualTexture texture = open_painted(p, options);
  ASSERT_TRUE(texture.attach(strict_host()).has_value());
  bool loaded = false;
  for (int frame = 0; frame < 60; ++frame) {
    const double u = 0.2 + 0.01 * frame;
    texture.set_center({u, 0.5});
    const FrameStats stats = texture.update();
    ASSERT_LE(stats.upload_bytes, 20000U);
    const StageSet set = texture.select({u, 0.5, u + 0.005, 0.505});
    loaded = loaded || set.count > 0;
    if (!loaded) {
      frame = -1;  // until there is something, frames do not count
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    ASSERT_TRUE(set.covers);
    texture.bind(set, {u, 0.5});
    // A texture that is only part loaded would show something else than the one colour of this world.
    const Frame drawn = draw_fixed(quad_views()[0], {}, {0.005, 0.005});
    for (std::size_t i = 0; i < drawn.size(); i += 4) ASSERT_EQ(drawn[i], 200) << "frame " << frame;
  }
  EXPECT_TRUE(loaded);
  texture.detach();
}

using Gl12Extensions = Gl12;

TEST_F(Gl12Extensions, Bc1IsUploadedAsItIsWhereTheDriverTakesIt) {
  const auto paint = [](Level level, std::int64_t x, std::int64_t y, std::byte* block) {
    noise_paint(TexelFormat::kBc1)(level, x, y, block);
    block[1] |= std::byte{0x80};
    block[3] &= std::byte{0x7F};
  };
  const Painted p = painted(TexelFormat::kBc1, 8, 3, paint);
  Options options;
  options.layout.tile_exponent = 9;
  const GlHost host{.getproc = tools::EglContext::getproc, .user = nullptr, .path = Path::kFixedFunction, .allow_extensions = true};
  GlHost plain = host;
  plain.allow_extensions = false;
  Frame frames[2];
  std::uint64_t bytes[2] = {};
  for (int i = 0; i < 2; ++i) {
    VirtualTexture texture = open_painted(p, options);
    ASSERT_TRUE(texture.attach(i == 0 ? host : plain).has_value());
    settle(texture);
    bytes[i] = texture.texture_bytes();
    const StageSet set = texture.select({0.45, 0.45, 0.55, 0.55});
    texture.bind(set, {0.45, 0.45});
    frames[i] = draw_fixed(quad_views()[0], {}, {0.1, 0.1});
    texture.detach();
  }
  EXPECT_EQ(bytes[1], bytes[0] * 8) << "blocks are an eighth of RGBA8";
  // The driver's own decoder is within 1.68 of exact; two such roundings and the filter's.
  EXPECT_LE(compare(frames[0], frames[1]).largest, 3);
}

// Runs only where a test entry has made the driver pretend.
using Gl12OnOldDriver = Gl12;

TEST_F(Gl12OnOldDriver, TheFixedPathWorksAndTheShaderPathSaysWhyNot) {
  const char* expected = std::getenv("VT_EXPECT_GL");
  if (expected == nullptr) GTEST_SKIP() << "run by the entries that set MESA_GL_VERSION_OVERRIDE";
  ASSERT_EQ(version_.substr(0, 3), expected);
  const Painted p = painted(TexelFormat::kBc1, 6, 3, noise_paint(TexelFormat::kBc1));
  VirtualTexture texture = open_painted(p, {});
  GlHost host{.getproc = tools::EglContext::getproc, .user = nullptr, .path = Path::kShader, .allow_extensions = true};
  const auto refused = texture.attach(host);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("2.1"), std::string::npos) << refused.error().message;
  host.path = Path::kFixedFunction;
  ASSERT_TRUE(texture.attach(host).has_value());
  settle(texture);
  const auto* extensions = reinterpret_cast<const char*>(gl_.GetString(0x1F03));
  const bool s3tc = std::string(extensions).find("GL_EXT_texture_compression_s3tc") != std::string::npos;
  EXPECT_EQ(texture.texture_bytes(), texture_bytes(p.layer, {}, !s3tc).value());
  texture.detach();
}

}  // namespace
}  // namespace vt::runtime
