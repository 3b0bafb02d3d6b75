// The tile textures as GL objects, with OpenGL 1.2 functions only; both back ends use it. GL thread, the
// context current.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "runtime/gl12_table.h"
#include "runtime/sub_load.h"
#include "runtime/virtual_texture.h"

namespace vt::runtime {

// How GL is told about a texel format.
struct GlPixelFormat {
  gl12::GLenum internal = 0;
  gl12::GLenum format = 0;  // both 0 for compressed formats
  gl12::GLenum type = 0;
  bool compressed = false;
  [[nodiscard]] bool is_none() const { return internal == 0; }
};

// Major * 100 + minor of a GL_VERSION string ("1.2 Mesa 22.3.6" is 102); 0 when there is none.
[[nodiscard]] int gl_version_number(const char* version);
// Whole words only: "GL_EXT_texture" is not in "GL_EXT_texture3D".
[[nodiscard]] bool has_word(std::string_view words, std::string_view word);

class GlTextures {
 public:
  [[nodiscard]] Result<void> load(const GlHost& host);
  [[nodiscard]] const gl12::TextureFunctions& gl() const { return gl_; }
  // Needed before a compressed format is used.
  void set_compression(const gl12::CompressionFunctions& functions) { compression_ = functions; }

  // From OpenGL 2.1 on a host may have a buffer bound that would turn our pointers into offsets; it is put
  // aside while we upload.
  struct UnpackBuffer {
    void (*bind)(gl12::GLenum target, gl12::GLuint buffer) = nullptr;
    gl12::GLenum target = 0;
    gl12::GLenum binding = 0;  // what glGetIntegerv asks for
  };
  void set_unpack_buffer(const UnpackBuffer& buffer) { unpack_buffer_ = buffer; }

  // A texture of 2^tile_exponent texels with `mips` levels, content undefined. kIo when GL is out of memory.
  [[nodiscard]] Result<unsigned> create(const GlPixelFormat& pixel, const FormatInfo& format, int tile_exponent, int mips);
  void destroy(unsigned texture);

  // Brackets uploads: sets the pixel store to tightly packed rows, and puts it and the texture binding back.
  void begin_uploads();
  void upload(unsigned texture, const GlPixelFormat& pixel, const Band& band, const std::byte* bytes);
  void end_uploads();

 private:
  void put_unpack_buffer_aside();
  void put_unpack_buffer_back();

  gl12::TextureFunctions gl_;
  gl12::CompressionFunctions compression_;
  UnpackBuffer unpack_buffer_;
  int saved_unpack_buffer_ = 0;
  unsigned upload_target_ = 0;  // bound by upload() inside the bracket
  int saved_binding_ = 0;
  int saved_pixel_store_[6] = {};
};

}  // namespace vt::runtime
