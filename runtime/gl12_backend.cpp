#include "runtime/gl12_backend.h"

#include "runtime/gl_formats.h"

namespace vt::runtime {

using namespace gl12;

Result<void> Gl12Backend::load(const GlHost& host, GlTextures& textures) {
  VT_CHECK(textures.load(host));
  if (const char* missing = gl_.load(host.getproc, host.user))
    return fail(ErrorCode::kUnsupported,
                std::string(missing) + " was not found by the host's getproc; the fixed-function path needs OpenGL 1.2");
  const auto* version = reinterpret_cast<const char*>(textures.gl().GetString(GL_VERSION));
  if (gl_version_number(version) < 102) return fail(ErrorCode::kUnsupported, std::string("OpenGL ") + version + " is older than 1.2");

  compressed_ = false;
  const auto* extensions = reinterpret_cast<const char*>(textures.gl().GetString(GL_EXTENSIONS));
  if (host.allow_extensions && extensions != nullptr && has_word(extensions, "GL_ARB_texture_compression") &&
      has_word(extensions, "GL_EXT_texture_compression_s3tc")) {
    gl12::CompressionFunctions functions;
    compressed_ = functions.load(host.getproc, host.user) == nullptr;
    if (compressed_) textures.set_compression(functions);
  }
  return {};
}

Result<Gl12Backend::Upload> Gl12Backend::upload_for(TexelFormat layer_format, bool must_be_plain) const {
  if (format_info(layer_format).samples == SampleKind::kOpaque)
    return fail(ErrorCode::kUnsupported, format_name(layer_format) + " layers hold no texture");
  const GlPixelFormat& own = gl_format(layer_format).fixed;
  if (own.compressed && compressed_ && !must_be_plain) return Upload{layer_format, own};
  const TexelFormat plain = format_info(layer_format).decoded_to;
  if (const GlPixelFormat& pixel = gl_format(plain).fixed; !pixel.is_none()) return Upload{plain, pixel};
  return fail(ErrorCode::kUnsupported,
              std::string(format_info(layer_format).name) + " textures do not exist in OpenGL 1.2; use the shader path");
}

void Gl12Backend::bind(GlTextures& textures, unsigned texture, bool already_bound, const TileMatrix& m) const {
  if (!already_bound) textures.gl().BindTexture(GL_TEXTURE_2D, texture);
  GLint mode = 0;
  gl_.GetIntegerv(GL_MATRIX_MODE, &mode);
  gl_.MatrixMode(GL_TEXTURE);
  const GLdouble columns[16] = {m.scale_x, 0, 0, 0, 0, m.scale_y, 0, 0, 0, 0, 1, 0, m.trans_x, m.trans_y, 0, 1};
  gl_.LoadMatrixd(columns);
  gl_.MatrixMode(static_cast<GLenum>(mode));
}

}  // namespace vt::runtime
