// The shader path: the GLSL function that combines several tiles, and its uniforms. OpenGL 2.1 or later,
// compatibility or core profile. GL thread, the context current.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "runtime/gl12_backend.h"
#include "runtime/glsl_table.h"

namespace vt::runtime {

// `vec4 NAME(vec2 uv)` for up to `stages` tiles. Uniforms: sampler2D NAME_tile0.. and vec4 NAME_map0..:
// U, V = uv * map.xy + map.zw.
[[nodiscard]] std::string glsl_function_text(std::string_view name, int stages);

class GlslBackend {
 public:
  [[nodiscard]] Result<void> load(const GlHost& host, GlTextures& textures);
  // As Gl12Backend's, but channels keep their names (one is red, two are red and green), and every format has
  // a texture from OpenGL 3.0 on.
  [[nodiscard]] Result<Gl12Backend::Upload> upload_for(TexelFormat layer_format, bool must_be_plain) const;
  // Finds the uniforms, points the samplers at their units. kUsage when the program has not the function's
  // uniforms.
  [[nodiscard]] Result<ShaderBinding> binding(unsigned program, std::string_view name, int first_unit, int stages) const;
  void bind_unit(GlTextures& textures, int unit, unsigned texture) const;
  void set_map(const ShaderBinding& binding, int stage, const TileMatrix& matrix) const;
  void mask(const ShaderBinding& binding, int stage) const;  // this stage never hits
  void leave_unit_zero_active() const { gl_.ActiveTexture(glsl::GL_TEXTURE0); }

 private:
  glsl::ShaderFunctions gl_;
  glsl::StringFunctions strings_;  // from 3.0 on
  [[nodiscard]] bool takes_blocks(TexelFormat format) const;
  [[nodiscard]] bool has_extension(const char* name, const GlTextures& textures) const;

  int version_ = 0;  // of OpenGL, major * 100 + minor
  // Which blocks the card takes.
  bool s3tc_ = false;
  bool rgtc_ = false;
  bool bptc_ = false;
};

}  // namespace vt::runtime
