// The shader path on a real OpenGL, in the compatibility profile (GLSL 1.20) and in the 3.3 core profile.
#include "tests/runtime/glsl_fixture.h"

namespace vt::runtime {
namespace {

using test::compare;
using test::Frame;
using test::kFrame;
using test::noise_paint;
using test::open_painted;
using test::painted;
using test::Painted;
using test::quad_views;
using test::QuadView;
using test::gl::GLuint;
namespace gl = test::gl;

using test::Glsl;

TEST_P(Glsl, AQuadOverFourTilesEqualsOneOrdinaryTexture) {
  const Painted p = painted(TexelFormat::kRgb8, 8, 3, noise_paint(TexelFormat::kRgb8));
  Options options;
  options.layout = {.tile_exponent = 9, .tiles_per_side = 1, .overrides = {}};
  VirtualTexture texture = open_painted(p, options);
  const auto attached = texture.attach(host());
  ASSERT_TRUE(attached.has_value()) << attached.error().message;
  texture.set_center({0.61, 0.37});
  settle(texture);
  const unsigned whole = ordinary_texture(p.paint, TexelFormat::kRgb8, p.layer.finest, 0, 0, 2048, 4);
  const GLuint through = program(VirtualTexture::glsl_function("vt_sample", 4), "colour = vt_sample(uv);");
  const auto binding = texture.shader_binding(through, "vt_sample", 1, 4);
  ASSERT_TRUE(binding.has_value()) << binding.error().message;
  const GLuint plain = program("uniform sampler2D image;\n", core() ? "colour = texture(image, uv);" : "colour = texture2D(image, uv);");
  for (const QuadView& view : quad_views()) {
    const double half = view.texels / 2.0 / 2048;
    const Point2 low{0.61 - half, 0.37 - half};
    const Point2 high{0.61 + half, 0.37 + half};
    shaders_.UseProgram(plain);
    shaders_.ActiveTexture(gl::GL_TEXTURE0);
    gl_.BindTexture(gl::GL_TEXTURE_2D, whole);
    const Frame reference = draw(plain, view, {low.x, 1.0 - low.y}, {high.x, 1.0 - high.y});
    shaders_.UseProgram(through);
    const StageSet set = texture.select({low.x, low.y, high.x, high.y});
    ASSERT_EQ(texture.tiles()[static_cast<std::size_t>(set.slots[0])].level, p.layer.finest);
    texture.bind(*binding, set, low);
    const Frame drawn = draw(through, view, {}, {high.x - low.x, high.y - low.y});
    EXPECT_GT(test::lit_pixels(drawn), 5000) << view.name;
    // A window by scale and translation: 2 on white noise, from 8-bit filter weights.
    EXPECT_LE(compare(reference, drawn).largest, 2) << view.name;
  }
  texture.detach();
}

// With a buffer bound there, OpenGL takes pointers for offsets into it.
TEST_P(Glsl, AHostsUnpackBufferIsPutAsideAndPutBack) {
  constexpr gl::GLenum kUnpackBuffer = 0x88EC;
  constexpr gl::GLenum kUnpackBufferBinding = 0x88EF;
  const Painted p = painted(TexelFormat::kRgb8, 8, 3, noise_paint(TexelFormat::kRgb8));
  Options options;
  options.layout = {.tile_exponent = 9, .tiles_per_side = 1, .overrides = {}};
  VirtualTexture texture = open_painted(p, options);
  GLuint host_buffer = 0;
  shaders_.GenBuffers(1, &host_buffer);
  shaders_.BindBuffer(kUnpackBuffer, host_buffer);
  shaders_.BufferData(kUnpackBuffer, 64, nullptr, gl::GL_STATIC_DRAW);
  const auto attached = texture.attach(host());
  ASSERT_TRUE(attached.has_value()) << attached.error().message;
  texture.set_center({0.61, 0.37});
  settle(texture);
  gl::GLint bound = 0;
  gl_.GetIntegerv(kUnpackBufferBinding, &bound);
  EXPECT_EQ(static_cast<GLuint>(bound), host_buffer);
  shaders_.BindBuffer(kUnpackBuffer, 0);

  const unsigned whole = ordinary_texture(p.paint, TexelFormat::kRgb8, p.layer.finest, 0, 0, 2048, 4);
  const GLuint through = program(VirtualTexture::glsl_function("vt_sample", 4), "colour = vt_sample(uv);");
  const auto binding = texture.shader_binding(through, "vt_sample", 1, 4);
  ASSERT_TRUE(binding.has_value()) << binding.error().message;
  const GLuint plain = program("uniform sampler2D image;\n", core() ? "colour = texture(image, uv);" : "colour = texture2D(image, uv);");
  const QuadView view = quad_views().front();
  const double half = view.texels / 2.0 / 2048;
  const Point2 low{0.61 - half, 0.37 - half};
  const Point2 high{0.61 + half, 0.37 + half};
  shaders_.UseProgram(plain);
  shaders_.ActiveTexture(gl::GL_TEXTURE0);
  gl_.BindTexture(gl::GL_TEXTURE_2D, whole);
  const Frame reference = draw(plain, view, {low.x, 1.0 - low.y}, {high.x, 1.0 - high.y});
  shaders_.UseProgram(through);
  texture.bind(*binding, texture.select({low.x, low.y, high.x, high.y}), low);
  const Frame drawn = draw(through, view, {}, {high.x - low.x, high.y - low.y});
  EXPECT_LE(compare(reference, drawn).largest, 2) << "8-bit filter weights, as for any window";
  texture.detach();
}

TEST_P(Glsl, StagesAreCombinedAsACompositorOnTheCpuWould) {
  const Painted p =
      painted(TexelFormat::kRgb8, 6, 6, [](Level, std::int64_t, std::int64_t, std::byte* t) { t[0] = t[1] = t[2] = std::byte{128}; });
  for (const int cap : {1, 2, 3, 4, 8, 16}) {
    for (const int side : {1, 2, 3}) {
      Options options;
      options.layout = {.tile_exponent = 6, .tiles_per_side = side, .overrides = {}};
      options.max_stages = cap;
      options.tint_levels = true;
      VirtualTexture texture = open_painted(p, options);
      ASSERT_TRUE(texture.attach(host()).has_value());
      texture.set_center({0.37, 0.58});
      settle(texture);
      const GLuint shader = program(VirtualTexture::glsl_function("vt_sample", cap), "colour = vt_sample(uv);");
      const auto binding = texture.shader_binding(shader, "vt_sample", 0, cap);
      ASSERT_TRUE(binding.has_value()) << binding.error().message;
      const StageSet set = texture.select({0, 0, 1, 1});
      ASSERT_TRUE(set.covers);
      ASSERT_LE(set.count, cap);
      texture.bind(*binding, set, {0.5, 0.5});
      const Frame drawn = draw(shader, quad_views()[0], {-0.5, -0.5}, {0.5, 0.5});

      // On the CPU: the first of the selected tiles that a pixel's center lies in. Every level has its own
      // tint.
      std::vector<VirtualTexture::TileState> tiles = texture.tiles();
      std::map<int, std::set<std::array<std::uint8_t, 3>>> seen;
      for (int y = 0; y < kFrame; ++y)
        for (int x = 0; x < kFrame; ++x) {
          const double u = (x + 0.5) / kFrame;
          const double v = (y + 0.5) / kFrame;
          bool near_edge = false;
          int level = -1;
          for (int i = 0; i < set.count && level < 0; ++i) {
            const auto& tile = tiles[static_cast<std::size_t>(set.slots[static_cast<std::size_t>(i)])];
            const double width = std::ldexp(1.0, 6 + tile.level.value);
            const double column = (u * width - static_cast<double>(tile.x)) / static_cast<double>(tile.texels);
            const double row = ((1 - v) * width - static_cast<double>(tile.y)) / static_cast<double>(tile.texels);
            const double pixel = width / static_cast<double>(tile.texels) / kFrame;
            for (const double at : {column, row}) near_edge = near_edge || std::abs(at) < 0.1 * pixel || std::abs(at - 1) < 0.1 * pixel;
            if (column >= 0 && column <= 1 && row >= 0 && row <= 1) level = tile.level.value;
          }
          ASSERT_GE(level, 0);
          if (near_edge) continue;
          const std::size_t at = static_cast<std::size_t>((y * kFrame + x) * 4);
          seen[level].insert({drawn[at], drawn[at + 1], drawn[at + 2]});
        }
      // One colour for each level, and no two levels the same.
      std::set<std::array<std::uint8_t, 3>> colours;
      for (const auto& [level, values] : seen) {
        EXPECT_EQ(values.size(), 1U) << "level " << level << " cap " << cap << " side " << side;
        colours.insert(values.begin(), values.end());
      }
      EXPECT_EQ(colours.size(), seen.size());
      EXPECT_TRUE(cap < 8 || side > 1 || seen.size() == 7U) << "all levels are seen, as concentric squares";
      texture.detach();
    }
  }
}

TEST_P(Glsl, SeveralVirtualTexturesOfDifferentSizeAndFormatShareOnePass) {
  const Painted a =
      painted(TexelFormat::kRgb8, 6, 5, [](Level, std::int64_t, std::int64_t, std::byte* t) { t[0] = t[1] = t[2] = std::byte{51}; });
  const Painted b = painted(TexelFormat::kRgba8, 8, 9,
                            [](Level, std::int64_t, std::int64_t, std::byte* t) { t[0] = t[1] = t[2] = t[3] = std::byte{102}; });
  const Painted c = painted(TexelFormat::kR32Float, 5, 4, [](Level, std::int64_t, std::int64_t, std::byte* t) {
    const float value = 1234.5F;
    std::memcpy(t, &value, 4);
  });
  Options small;
  small.layout = {.tile_exponent = 6, .tiles_per_side = 2, .overrides = {}};
  VirtualTexture colour = open_painted(a, small);
  VirtualTexture mask = open_painted(b, {});
  VirtualTexture height = open_painted(c, small);
  const GLuint shader = program(VirtualTexture::glsl_function("colour_vt", 4) + VirtualTexture::glsl_function("mask_vt", 2) +
                                    VirtualTexture::glsl_function("height_vt", 3),
                                "colour = vec4(colour_vt(uv).r, mask_vt(uv).a, height_vt(uv).r / 2469.0, 1.0);");
  int unit = 0;
  const std::pair<VirtualTexture*, std::pair<const char*, int>> parts[] = {
      {&colour, {"colour_vt", 4}}, {&mask, {"mask_vt", 2}}, {&height, {"height_vt", 3}}};
  for (const auto& [texture, part] : parts) {
    const auto attached = texture->attach(host());
    ASSERT_TRUE(attached.has_value()) << attached.error().message;
    settle(*texture);
    const auto binding = texture->shader_binding(shader, part.first, unit, part.second);
    ASSERT_TRUE(binding.has_value()) << binding.error().message;
    const StageSet set = texture->select({0.4, 0.4, 0.6, 0.6}, part.second);
    texture->bind(*binding, set, {0.5, 0.5});
    unit += part.second;
  }
  const Frame drawn = draw(shader, quad_views()[0], {-0.01, -0.01}, {0.01, 0.01});
  for (std::size_t i = 0; i < drawn.size(); i += 4) {
    ASSERT_EQ(drawn[i], 51);
    ASSERT_EQ(drawn[i + 1], 102);
    ASSERT_NEAR(drawn[i + 2], 127.5, 1);
  }
  for (const auto& [texture, part] : parts) texture->detach();
}

TEST_P(Glsl, AProgramWithoutTheFunctionIsRefusedWithAdvice) {
  const Painted p = painted(TexelFormat::kRgb8, 5, 2, noise_paint(TexelFormat::kRgb8));
  VirtualTexture texture = open_painted(p, {});
  ASSERT_TRUE(texture.attach(host()).has_value());
  const GLuint shader = program("", "colour = vec4(uv, 0.0, 1.0);");
  const auto binding = texture.shader_binding(shader, "vt_sample", 0, 4);
  ASSERT_FALSE(binding.has_value());
  EXPECT_NE(binding.error().message.find("glsl_function"), std::string::npos);
  EXPECT_FALSE(texture.shader_binding(shader, "vt_sample", 30, 4).has_value()) << "there are 32 units";
  texture.detach();
}

INSTANTIATE_TEST_SUITE_P(Profiles, Glsl, ::testing::Values(tools::GlProfile::kCompatibility, tools::GlProfile::kCore33),
                         [](const auto& profile) { return profile.param == tools::GlProfile::kCore33 ? "Core33" : "Compatibility"; });

}  // namespace
}  // namespace vt::runtime
