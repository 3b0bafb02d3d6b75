#include "runtime/glsl_backend.h"

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

  bool s3tc = false;
  if (number >= 300) {
    glsl::StringFunctions strings;
    if (strings.load(host.getproc, host.user) == nullptr) {
      glsl::GLint count = 0;
      gl_.GetIntegerv(glsl::GL_NUM_EXTENSIONS, &count);
      for (glsl::GLint i = 0; i < count && !s3tc; ++i) {
        const auto* extension = reinterpret_cast<const char*>(strings.GetStringi(glsl::GL_EXTENSIONS, static_cast<glsl::GLuint>(i)));
        s3tc = extension != nullptr && std::string_view(extension) == "GL_EXT_texture_compression_s3tc";
      }
    }
  } else if (const auto* extensions = reinterpret_cast<const char*>(textures.gl().GetString(gl12::GL_EXTENSIONS))) {
    s3tc = has_word(extensions, "GL_EXT_texture_compression_s3tc");
  }
  floats_ = number >= 300;
  compressed_ = false;
  if (s3tc && host.allow_extensions) {
    glsl::CompressionFunctions core;
    compressed_ = core.load(host.getproc, host.user) == nullptr;
    if (compressed_)
      textures.set_compression(
          {.CompressedTexImage2DARB = core.CompressedTexImage2D, .CompressedTexSubImage2DARB = core.CompressedTexSubImage2D});
  }
  return {};
}

Result<Gl12Backend::Upload> GlslBackend::upload_for(TexelFormat layer_format, bool must_be_plain) const {
  using Upload = Gl12Backend::Upload;
  if (!floats_ && format_info(layer_format).samples == SampleKind::kFloat)
    return fail(ErrorCode::kUnsupported, std::string(format_info(layer_format).name) + " textures need OpenGL 3.0");
  switch (layer_format) {
    case TexelFormat::kRgb8:
    case TexelFormat::kRgba8:
      return Upload{layer_format, plain_pixel_format(layer_format)};
    case TexelFormat::kBc1:
      if (compressed_ && !must_be_plain)
        return Upload{layer_format, {.internal = gl12::GL_COMPRESSED_RGB_S3TC_DXT1_EXT, .format = 0, .type = 0, .compressed = true}};
      return Upload{TexelFormat::kRgba8, plain_pixel_format(TexelFormat::kRgba8)};
    case TexelFormat::kR32Float:
      return Upload{layer_format, {.internal = glsl::GL_R32F, .format = gl12::GL_RED, .type = gl12::GL_FLOAT}};
    case TexelFormat::kRg32Float:
      return Upload{layer_format, {.internal = glsl::GL_RG32F, .format = glsl::GL_RG, .type = gl12::GL_FLOAT}};
    case TexelFormat::kRgba32Float:
      return Upload{layer_format, {.internal = glsl::GL_RGBA32F, .format = gl12::GL_RGBA, .type = gl12::GL_FLOAT}};
    case TexelFormat::kHash128:
    case TexelFormat::kBlob:
      return fail(ErrorCode::kUnsupported, std::string(format_info(layer_format).name) + " layers hold no texture");
    default:
      break;
  }
  return fail(ErrorCode::kUnsupported, std::string(format_info(layer_format).name) + " textures are not drawn by the shader path");
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
