#include "runtime/gl_textures.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace vt::runtime {
namespace {

using namespace gl12;

// Rows follow one another without gaps and bytes are as they are in memory.
constexpr std::array<std::pair<GLenum, GLint>, 6> kTightRows = {{{GL_UNPACK_ALIGNMENT, 1},
                                                                 {GL_UNPACK_ROW_LENGTH, 0},
                                                                 {GL_UNPACK_SKIP_ROWS, 0},
                                                                 {GL_UNPACK_SKIP_PIXELS, 0},
                                                                 {GL_UNPACK_SWAP_BYTES, 0},
                                                                 {GL_UNPACK_LSB_FIRST, 0}}};

}  // namespace

int gl_version_number(const char* version) {
  if (version == nullptr) return 0;
  char* end = nullptr;
  const long major = std::strtol(version, &end, 10);
  if (end == version || *end != '.') return 0;
  return static_cast<int>(major * 100 + std::strtol(end + 1, nullptr, 10));
}

bool has_word(std::string_view words, std::string_view word) {
  for (std::size_t at = words.find(word); at != std::string_view::npos; at = words.find(word, at + 1)) {
    const bool begins = at == 0 || words[at - 1] == ' ';
    const bool ends = at + word.size() == words.size() || words[at + word.size()] == ' ';
    if (begins && ends) return true;
  }
  return false;
}

Result<void> GlTextures::load(const GlHost& host) {
  if (host.getproc == nullptr) return fail(ErrorCode::kUsage, "no getproc was given: the host must say how to find OpenGL functions");
  if (const char* missing = gl_.load(host.getproc, host.user))
    return fail(ErrorCode::kUnsupported, std::string(missing) + " was not found by the host's getproc; OpenGL 1.2 is needed");
  if (gl_.GetString(GL_VERSION) == nullptr) return fail(ErrorCode::kUsage, "no OpenGL context is current on this thread");
  return {};
}

Result<unsigned> GlTextures::create(const GlPixelFormat& pixel, const FormatInfo& format, int tile_exponent, int mips) {
  // Older errors are the host's. A lost context may report one for ever.
  for (int i = 0; i < 16 && gl_.GetError() != GL_NO_ERROR; ++i) {
  }
  GLint largest = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if ((GLint{1} << tile_exponent) > largest)
    return fail(ErrorCode::kUnsupported, "tiles of 2^" + std::to_string(tile_exponent) +
                                             " texels are larger than the largest texture of this OpenGL, " + std::to_string(largest));
  GLint bound = 0;
  gl_.GetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  GLuint texture = 0;
  gl_.GenTextures(1, &texture);
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, static_cast<GLint>(GL_CLAMP_TO_EDGE));
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, static_cast<GLint>(GL_CLAMP_TO_EDGE));
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(GL_LINEAR));
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(mips > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR));
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_BASE_LEVEL, 0);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, mips - 1);
  put_unpack_buffer_aside();
  for (int mip = 0; mip < mips; ++mip) {
    const GLsizei edge = 1 << (tile_exponent - mip);
    if (pixel.compressed) {
      // Some drivers refuse a compressed image without data, so it gets one block of zeros after another.
      const std::vector<std::byte> zeros(payload_bytes(format, static_cast<std::size_t>(edge), static_cast<std::size_t>(edge)));
      compression_.CompressedTexImage2DARB(GL_TEXTURE_2D, mip, pixel.internal, edge, edge, 0, static_cast<GLsizei>(zeros.size()),
                                           zeros.data());
    } else {
      gl_.TexImage2D(GL_TEXTURE_2D, mip, static_cast<GLint>(pixel.internal), edge, edge, 0, pixel.format, pixel.type, nullptr);
    }
  }
  put_unpack_buffer_back();
  gl_.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(bound));
  if (const GLenum error = gl_.GetError(); error != GL_NO_ERROR) {
    gl_.DeleteTextures(1, &texture);
    if (error == GL_OUT_OF_MEMORY) return fail(ErrorCode::kIo, "out of texture memory; choose smaller or fewer tiles");
    return fail(ErrorCode::kUnsupported, "OpenGL refused a " + std::string(format.name) + " texture of 2^" + std::to_string(tile_exponent) +
                                             " texels with error " + std::to_string(error));
  }
  return texture;
}

void GlTextures::destroy(unsigned texture) { gl_.DeleteTextures(1, &texture); }

void GlTextures::put_unpack_buffer_aside() {
  if (unpack_buffer_.bind == nullptr) return;
  gl_.GetIntegerv(unpack_buffer_.binding, &saved_unpack_buffer_);
  if (saved_unpack_buffer_ != 0) unpack_buffer_.bind(unpack_buffer_.target, 0);
}

void GlTextures::put_unpack_buffer_back() {
  if (unpack_buffer_.bind != nullptr && saved_unpack_buffer_ != 0)
    unpack_buffer_.bind(unpack_buffer_.target, static_cast<gl12::GLuint>(saved_unpack_buffer_));
}

void GlTextures::begin_uploads() {
  put_unpack_buffer_aside();
  gl_.GetIntegerv(GL_TEXTURE_BINDING_2D, &saved_binding_);
  for (std::size_t i = 0; i < kTightRows.size(); ++i) {
    gl_.GetIntegerv(kTightRows[i].first, &saved_pixel_store_[i]);
    gl_.PixelStorei(kTightRows[i].first, kTightRows[i].second);
  }
  upload_target_ = 0;
}

void GlTextures::upload(unsigned texture, const GlPixelFormat& pixel, const Band& band, const std::byte* bytes) {
  if (texture != upload_target_) gl_.BindTexture(GL_TEXTURE_2D, texture);
  upload_target_ = texture;
  if (pixel.compressed)
    compression_.CompressedTexSubImage2DARB(GL_TEXTURE_2D, band.mip, band.x, band.y, band.width, band.height, pixel.internal,
                                            static_cast<GLsizei>(band.bytes), bytes);
  else
    gl_.TexSubImage2D(GL_TEXTURE_2D, band.mip, band.x, band.y, band.width, band.height, pixel.format, pixel.type, bytes);
}

void GlTextures::end_uploads() {
  for (std::size_t i = 0; i < kTightRows.size(); ++i) gl_.PixelStorei(kTightRows[i].first, saved_pixel_store_[i]);
  gl_.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(saved_binding_));
  put_unpack_buffer_back();
}

}  // namespace vt::runtime
