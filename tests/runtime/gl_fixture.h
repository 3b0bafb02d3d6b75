// A real OpenGL context for a test, with what it takes to draw a quad the ordinary way. The fixed-function
// part uses OpenGL 1.2 alone, so that the trace of a whole test program can be checked.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "runtime/virtual_texture.h"
#include "tests/runtime/test_store.h"
#include "tools/vtrender/egl_context.h"
#include "tools/vtrender/gl_table.h"

namespace vt::tools {
inline void PrintTo(GlProfile profile, std::ostream* out) { *out << (profile == GlProfile::kCore33 ? "3.3 core" : "compatibility"); }
}  // namespace vt::tools

namespace vt::runtime::test {

inline constexpr int kFrame = 512;
namespace gl = tools::gl;

// Knows the functions of OpenGL 1.2; refuses and counts everything else.
struct StrictGetProc {
  std::set<std::string> known;
  std::set<std::string> refused;

  StrictGetProc() {
    std::ifstream names(VT_GL12_NAMES);
    for (std::string name; names >> name;) known.insert(name);
  }
  static void* getproc(const char* name, void* user) {
    auto* self = static_cast<StrictGetProc*>(user);
    if (self->known.contains(name)) return tools::EglContext::getproc(name, nullptr);
    self->refused.insert(name);
    return nullptr;
  }
};

using Frame = std::vector<std::uint8_t>;  // RGBA

struct Difference {
  int largest = 0;
  int pixels = 0;  // that differ at all
};
inline Difference compare(const Frame& a, const Frame& b) {
  Difference d;
  for (std::size_t i = 0; i < a.size(); i += 4) {
    int here = 0;
    for (std::size_t c = 0; c < 3; ++c) here = std::max(here, std::abs(int{a[i + c]} - int{b[i + c]}));
    d.largest = std::max(d.largest, here);
    d.pixels += here > 0 ? 1 : 0;
  }
  return d;
}
inline int lit_pixels(const Frame& frame) {
  int count = 0;
  for (std::size_t i = 0; i < frame.size(); i += 4) count += frame[i + 3] > 0 ? 1 : 0;
  return count;
}

// A quad in a view: its corners in the plane (x, y) of -1..1, and the matrix that takes (x, y, 0) to the
// screen.
struct QuadView {
  const char* name;
  std::array<double, 16> matrix;
  int texels;  // how wide the quad is in texels of the finest level
};

inline std::vector<QuadView> quad_views() {
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  // 60 degrees of perspective, looking down at the quad from 30 degrees above its plane.
  const double f = 1.0 / std::tan(0.52359877559829887);
  const double near = 0.1;
  const double far = 10.0;
  const double a = (far + near) / (near - far);
  const double b = 2 * far * near / (near - far);
  const double cp = std::cos(-1.05);
  const double sp = std::sin(-1.05);
  // Rotated about x by -60 degrees, then moved 1.6 away: z' = sp * y - 1.6 (before the projection).
  return {{"one texel a pixel", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, kFrame * 3 / 4},
          {"magnified", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 61},
          {"rotated", {c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 233},
          {"minified three times", {0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 384},
          {"perspective", {f, 0, 0, 0, 0, f * cp, a * sp, -sp, 0, 0, 0, 0, 0, 0, a * -1.6 + b, 1.6}, 380}};
}

class GlTest : public ::testing::Test {
 protected:
  void open(tools::GlProfile profile) {
    auto made = tools::EglContext::create(kFrame, kFrame, profile);
    if (!made) GTEST_SKIP() << made.error().message;
    context_.emplace(std::move(*made));
    const bool fixed_only = std::getenv("VT_GL12_ONLY") != nullptr;
    if (!fixed_only) {
      ASSERT_EQ(debug_.load(tools::EglContext::getproc, nullptr), nullptr);
    }
    ASSERT_EQ(gl_.load(tools::EglContext::getproc, nullptr), nullptr);
    version_ = reinterpret_cast<const char*>(gl_.GetString(gl::GL_VERSION));
    if (!fixed_only && version_[0] >= '3') {
      gl_.Enable(gl::GL_DEBUG_OUTPUT);
      gl_.Enable(gl::GL_DEBUG_OUTPUT_SYNCHRONOUS);
      debug_.DebugMessageCallback(on_message, nullptr);
    }
    gl_.Viewport(0, 0, kFrame, kFrame);
    gl_.ClearColor(0, 0, 0, 0);
  }
  void TearDown() override {
    if (!context_) return;
    EXPECT_EQ(gl_.GetError(), gl::GL_NO_ERROR);
  }

  static void settle(VirtualTexture& texture) {
    texture.update();
    while (!texture.settled()) {  // however busy the machine is
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      texture.update();
    }
    ASSERT_EQ(texture.last_error(), "");
  }

  // An ordinary texture of a square of the finest level and as many coarser ones as divide it.
  unsigned ordinary_texture(const Paint& paint, TexelFormat format, Level finest, std::int64_t x, std::int64_t y, int edge, int mips) {
    unsigned name = 0;
    gl_.GenTextures(1, &name);
    gl_.BindTexture(gl::GL_TEXTURE_2D, name);
    const auto parameter = [&](gl::GLenum what, gl::GLenum value) {
      gl_.TexParameteri(gl::GL_TEXTURE_2D, what, static_cast<gl::GLint>(value));
    };
    parameter(gl::GL_TEXTURE_WRAP_S, gl::GL_CLAMP_TO_EDGE);
    parameter(gl::GL_TEXTURE_WRAP_T, gl::GL_CLAMP_TO_EDGE);
    parameter(gl::GL_TEXTURE_MAG_FILTER, gl::GL_LINEAR);
    parameter(gl::GL_TEXTURE_MIN_FILTER, gl::GL_LINEAR_MIPMAP_LINEAR);
    parameter(gl::GL_TEXTURE_MAX_LEVEL, static_cast<gl::GLenum>(mips - 1));
    gl_.PixelStorei(gl::GL_UNPACK_ALIGNMENT, 1);
    const int bytes = format_info(format).block_bytes;
    for (int mip = 0; mip < mips; ++mip) {
      const int width = edge >> mip;
      std::vector<std::byte> texels(static_cast<std::size_t>(width) * static_cast<std::size_t>(width) * static_cast<std::size_t>(bytes));
      for (int j = 0; j < width; ++j)
        for (int i = 0; i < width; ++i)
          paint(Level{static_cast<std::uint8_t>(finest.value - mip)}, (x >> mip) + i, (y >> mip) + j,
                texels.data() + (static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)) *
                                    static_cast<std::size_t>(bytes));
      gl_.TexImage2D(gl::GL_TEXTURE_2D, mip, static_cast<gl::GLint>(bytes == 3 ? gl::GL_RGB8 : gl::GL_RGBA8), width, width, 0,
                     bytes == 3 ? gl::GL_RGB : gl::GL_RGBA, gl::GL_UNSIGNED_BYTE, texels.data());
    }
    return name;
  }

  [[nodiscard]] Frame pixels() {
    Frame frame(static_cast<std::size_t>(kFrame) * kFrame * 4);
    gl_.PixelStorei(gl::GL_PACK_ALIGNMENT, 1);
    gl_.ReadPixels(0, 0, kFrame, kFrame, gl::GL_RGBA, gl::GL_UNSIGNED_BYTE, frame.data());
    return frame;
  }

  // Fixed function: the quad with texture coordinates from `low` to `high`, as doubles that become floats
  // only in GL.
  Frame draw_fixed(const QuadView& view, Point2 low, Point2 high) {
    gl_.Clear(gl::GL_COLOR_BUFFER_BIT);
    gl_.Enable(gl::GL_TEXTURE_2D);
    gl_.TexEnvi(gl::GL_TEXTURE_ENV, gl::GL_TEXTURE_ENV_MODE, static_cast<gl::GLint>(gl::GL_REPLACE));
    gl_.MatrixMode(gl::GL_PROJECTION);
    gl_.LoadMatrixd(view.matrix.data());
    gl_.MatrixMode(gl::GL_MODELVIEW);
    gl_.LoadIdentity();
    gl_.Begin(gl::GL_QUADS);
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      gl_.TexCoord2d(x == 0 ? low.x : high.x, y == 0 ? low.y : high.y);
      gl_.Vertex2f(x == 0 ? -1.0F : 1.0F, y == 0 ? -1.0F : 1.0F);
    }
    gl_.End();
    return pixels();
  }
  void texture_matrix_identity() {
    gl_.MatrixMode(gl::GL_TEXTURE);
    gl_.LoadIdentity();
  }

  std::optional<tools::EglContext> context_;
  gl::FixedFunctions gl_;
  gl::DebugFunctions debug_;
  std::string version_;

 private:
  static void VT_GL_CALL on_message(gl::GLenum, gl::GLenum type, gl::GLuint, gl::GLenum, gl::GLsizei, const gl::GLchar* message,
                                    const void*) {
    if (type == gl::GL_DEBUG_TYPE_ERROR) ADD_FAILURE() << "OpenGL: " << message;
  }
};

// A virtual texture whose texels are a formula, over the unit square.
struct Painted {
  LayerInfo layer;
  Paint paint;
  std::shared_ptr<PaintedSource> source;
};
inline Painted painted(TexelFormat format, int tile_exponent, int finest, Paint paint) {
  const Area area{.west = 0, .south = 0, .east = 1, .north = 1};
  Painted p{
      .layer = layer_info({.format = format, .tile_exponent = tile_exponent, .finest = finest, .data = {}, .paint = {}, .skip = {}}, area),
      .paint = paint,
      .source = std::make_shared<PaintedSource>(format, paint)};
  return p;
}
inline VirtualTexture open_painted(const Painted& p, Options options) {
  return VirtualTexture::open(p.source, Area{.west = 0, .south = 0, .east = 1, .north = 1}, p.layer, std::move(options)).value();
}

}  // namespace vt::runtime::test
