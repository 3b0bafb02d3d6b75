// A real OpenGL context for tests of the shader path, in the compatibility profile (GLSL 1.20) or the 3.3
// core profile, with what it takes to draw a quad through a program.
#pragma once

#include <string>

#include "tests/runtime/gl_fixture.h"

namespace vt::runtime::test {

class Glsl : public GlTest, public ::testing::WithParamInterface<tools::GlProfile> {
 protected:
  void SetUp() override {
    open(GetParam());
    if (IsSkipped() || HasFatalFailure()) return;
    if (version_[0] < '2') GTEST_SKIP() << "the driver offers OpenGL " << version_ << "; shaders need 2.1";
    ASSERT_EQ(shaders_.load(tools::EglContext::getproc, nullptr), nullptr);
    if (core()) {
      gl::GLuint array = 0;
      shaders_.GenVertexArrays(1, &array);
      shaders_.BindVertexArray(array);
    }
    shaders_.GenBuffers(1, &buffer_);
  }
  [[nodiscard]] static bool core() { return GetParam() == tools::GlProfile::kCore33; }

  static GlHost host() { return {.getproc = tools::EglContext::getproc, .user = nullptr, .path = Path::kShader, .allow_extensions = true}; }

  // A program whose fragment shader sets `colour` from `uv`.
  gl::GLuint program(const std::string& functions, const std::string& body) {
    const std::string head = core() ? "#version 330 core\n" : "#version 120\n";
    const std::string in = core() ? "in" : "attribute";
    const std::string vertex = head + in + " vec2 place;\n" + in + " vec2 coordinate;\nuniform mat4 matrix;\n" +
                               (core() ? "out" : "varying") +
                               " vec2 uv;\nvoid main() { uv = coordinate; gl_Position = matrix * vec4(place, 0.0, 1.0); }\n";
    const std::string fragment = head + (core() ? "in vec2 uv;\nout vec4 result;\n" : "varying vec2 uv;\n") + functions +
                                 "void main() { vec4 colour;\n" + body + "\n" + (core() ? "result" : "gl_FragColor") + " = colour; }\n";
    const gl::GLuint made = shaders_.CreateProgram();
    for (const auto& [type, text] : {std::pair(gl::GL_VERTEX_SHADER, &vertex), std::pair(gl::GL_FRAGMENT_SHADER, &fragment)}) {
      const gl::GLuint shader = shaders_.CreateShader(type);
      const char* source = text->c_str();
      shaders_.ShaderSource(shader, 1, &source, nullptr);
      shaders_.CompileShader(shader);
      gl::GLint ok = 0;
      shaders_.GetShaderiv(shader, gl::GL_COMPILE_STATUS, &ok);
      char log[2048] = {};
      if (ok == 0) shaders_.GetShaderInfoLog(shader, sizeof log, nullptr, log);
      EXPECT_NE(ok, 0) << log << *text;
      shaders_.AttachShader(made, shader);
    }
    shaders_.BindAttribLocation(made, 0, "place");
    shaders_.BindAttribLocation(made, 1, "coordinate");
    shaders_.LinkProgram(made);
    shaders_.UseProgram(made);
    return made;
  }

  Frame draw(gl::GLuint with, const QuadView& view, Point2 low, Point2 high) {
    std::array<float, 16> matrix{};
    for (std::size_t i = 0; i < 16; ++i) matrix[i] = static_cast<float>(view.matrix[i]);
    shaders_.UniformMatrix4fv(shaders_.GetUniformLocation(with, "matrix"), 1, 0, matrix.data());
    const auto f = [](double d) { return static_cast<float>(d); };
    const float vertices[] = {-1, -1, f(low.x), f(low.y),  1, -1, f(high.x), f(low.y),
                              -1, 1,  f(low.x), f(high.y), 1, 1,  f(high.x), f(high.y)};
    shaders_.BindBuffer(gl::GL_ARRAY_BUFFER, buffer_);
    shaders_.BufferData(gl::GL_ARRAY_BUFFER, sizeof vertices, vertices, gl::GL_STATIC_DRAW);
    for (gl::GLuint k = 0; k < 2; ++k) {
      shaders_.EnableVertexAttribArray(k);
      shaders_.VertexAttribPointer(k, 2, gl::GL_FLOAT, 0, 16, reinterpret_cast<const void*>(static_cast<std::uintptr_t>(k * 8)));
    }
    gl_.Clear(gl::GL_COLOR_BUFFER_BIT);
    shaders_.DrawArrays(gl::GL_TRIANGLE_STRIP, 0, 4);
    return pixels();
  }

  gl::ShaderFunctions shaders_;
  gl::GLuint buffer_ = 0;
};

}  // namespace vt::runtime::test
