#include "runtime/glsl_backend.h"

#include "runtime/gl_formats.h"

namespace vt::runtime {

std::string glsl_function_text(std::string_view name, int stages) {
  const std::string n(name);
  std::string text = "// Written by vt::runtime::VirtualTexture::glsl_function().\n";
  text +=
      "#ifndef VT_TEXTURE\n#if __VERSION__ >= 130\n#define VT_TEXTURE texture\n#else\n#define VT_TEXTURE texture2D\n#endif\n"
      "// 1e-5 is what float rounding may take from both of two tiles that touch; without it a fragment on their border would be in "
      "neither.\n"
      "bool vt_inside(vec2 p) { vec2 d = abs(p - 0.5); return max(d.x, d.y) <= 0.50001; }\n#endif\n";
  for (int i = 0; i < stages; ++i) {
    const std::string k = std::to_string(i);
    text += "uniform sampler2D " + n + "_tile" + k + ";\nuniform vec4 " + n + "_map" + k + ";\n";
  }
  // Every stage is fetched whether it is used or not: a fetch inside a branch has no defined derivatives.
  text +=
      "vec4 " + n + "(vec2 uv) {\n  vec4 value = vec4(0.0);\n  bool open = true;  // no finer tile was hit yet\n  vec2 p;\n  vec4 texel;\n";
  for (int i = 0; i < stages; ++i) {
    const std::string k = std::to_string(i);
    text += "  p = uv * " + n + "_map" + k + ".xy + " + n + "_map" + k + ".zw;\n";
    text += "  texel = VT_TEXTURE(" + n + "_tile" + k + ", p);\n";
    text += "  if (open && vt_inside(p)) { value = texel; open = false; }\n";
  }
  text += "  return value;\n}\n";
  return text;
}

Result<void> GlslBackend::load(const GlHost& host, GlTextures& textures) {
  VT_CHECK(textures.load(host));
  const auto* version = reinterpret_cast<const char*>(textures.gl().GetString(gl12::GL_VERSION));
  const int number = gl_version_number(version);
  // The version counts, not the pointer: getprocs return pointers for names that do not exist.
  if (number < 201)
    return fail(ErrorCode::kUnsupported,
                std::string("the shader path needs OpenGL 2.1; this context is ") + version + "; use the fixed-function path");
  if (const char* missing = gl_.load(host.getproc, host.user))
    return fail(ErrorCode::kUnsupported, std::string(missing) + " was not found by the host's getproc; the shader path needs OpenGL 2.1");

  textures.set_unpack_buffer(
      {.bind = gl_.BindBuffer, .target = glsl::GL_PIXEL_UNPACK_BUFFER, .binding = glsl::GL_PIXEL_UNPACK_BUFFER_BINDING});

  version_ = number;
  s3tc_ = rgtc_ = bptc_ = false;
  strings_ = {};
  if (number >= 300 && strings_.load(host.getproc, host.user) != nullptr) strings_ = {};
  glsl::CompressionFunctions core;
  if (!host.allow_extensions || core.load(host.getproc, host.user) != nullptr) return {};
  textures.set_compression(
      {.CompressedTexImage2DARB = core.CompressedTexImage2D, .CompressedTexSubImage2DARB = core.CompressedTexSubImage2D});
  rgtc_ = number >= 300;
  s3tc_ = has_extension("GL_EXT_texture_compression_s3tc", textures);
  bptc_ = number >= 402 || has_extension("GL_ARB_texture_compression_bptc", textures);
  return {};
}

bool GlslBackend::has_extension(const char* name, const GlTextures& textures) const {
  if (version_ < 300) {
    const auto* all = reinterpret_cast<const char*>(textures.gl().GetString(gl12::GL_EXTENSIONS));
    return all != nullptr && has_word(all, name);
  }
  if (strings_.GetStringi == nullptr) return false;
  glsl::GLint count = 0;
  gl_.GetIntegerv(glsl::GL_NUM_EXTENSIONS, &count);
  for (glsl::GLint i = 0; i < count; ++i) {
    const auto* extension = reinterpret_cast<const char*>(strings_.GetStringi(glsl::GL_EXTENSIONS, static_cast<glsl::GLuint>(i)));
    if (extension != nullptr && std::string_view(extension) == name) return true;
  }
  return false;
}

bool GlslBackend::takes_blocks(TexelFormat format) const {
  switch (gl_format(format).blocks) {
    case BlockSupport::kNotBlocks:
      return false;
    case BlockSupport::kS3tc:
      return s3tc_;
    case BlockSupport::kRgtc:
      return rgtc_;
    case BlockSupport::kBptc:
      return bptc_;
  }
  return false;
}

Result<Gl12Backend::Upload> GlslBackend::upload_for(TexelFormat layer_format, bool must_be_plain) const {
  const std::string name = format_name(layer_format);
  if (format_info(layer_format).samples == SampleKind::kOpaque) return fail(ErrorCode::kUnsupported, name + " layers hold no texture");
  const bool is_block = takes_blocks(layer_format) && !must_be_plain;
  const TexelFormat format = is_block ? layer_format : format_info(layer_format).decoded_to;
  const GlFormat& row = gl_format(format);
  if (version_ >= 300 || is_block) return Gl12Backend::Upload{format, row.shader};
  // Before 3.0 there is only what the fixed path has, of which two channels would be red and alpha.
  if (!row.fixed.is_none() && format_info(format).channels != 2) return Gl12Backend::Upload{format, row.fixed};
  return fail(ErrorCode::kUnsupported, name + " textures need OpenGL 3.0");
}

Result<ShaderBinding> GlslBackend::binding(unsigned program, std::string_view name, int first_unit, int stages) const {
  if (stages < 1 || stages > kMaxStages) return fail(ErrorCode::kUsage, "1 to 16 stages; " + std::to_string(stages) + " were asked for");
  glsl::GLint units = 0;
  gl_.GetIntegerv(glsl::GL_MAX_TEXTURE_IMAGE_UNITS, &units);
  if (first_unit < 0 || first_unit + stages > units)
    return fail(ErrorCode::kUsage, "units " + std::to_string(first_unit) + " to " + std::to_string(first_unit + stages - 1) +
                                       " are more than this OpenGL's " + std::to_string(units) + " texture units");
  ShaderBinding binding{.program = program, .first_unit = first_unit, .stages = stages, .map_locations = {}};
  for (int i = 0; i < stages; ++i) {
    const std::string sampler = std::string(name) + "_tile" + std::to_string(i);
    const std::string map = std::string(name) + "_map" + std::to_string(i);
    const glsl::GLint sampler_location = gl_.GetUniformLocation(program, sampler.c_str());
    binding.map_locations[static_cast<std::size_t>(i)] = gl_.GetUniformLocation(program, map.c_str());
    if (sampler_location < 0 || binding.map_locations[static_cast<std::size_t>(i)] < 0)
      return fail(ErrorCode::kUsage, "the program has no uniform " + sampler + "; put glsl_function(\"" + std::string(name) + "\", " +
                                         std::to_string(stages) + ") before main() and call " + std::string(name) + "()");
    gl_.Uniform1i(sampler_location, first_unit + i);
  }
  return binding;
}

void GlslBackend::bind_unit(GlTextures& textures, int unit, unsigned texture) const {
  gl_.ActiveTexture(glsl::GL_TEXTURE0 + static_cast<glsl::GLenum>(unit));
  textures.gl().BindTexture(gl12::GL_TEXTURE_2D, texture);
}

void GlslBackend::set_map(const ShaderBinding& binding, int stage, const TileMatrix& m) const {
  const float map[4] = {static_cast<float>(m.scale_x), static_cast<float>(m.scale_y), static_cast<float>(m.trans_x),
                        static_cast<float>(m.trans_y)};
  gl_.Uniform4fv(binding.map_locations[static_cast<std::size_t>(stage)], 1, map);
}

void GlslBackend::mask(const ShaderBinding& binding, int stage) const {
  static constexpr float kNowhere[4] = {0.0F, 0.0F, -1.0F, -1.0F};
  gl_.Uniform4fv(binding.map_locations[static_cast<std::size_t>(stage)], 1, kNowhere);
}

}  // namespace vt::runtime
