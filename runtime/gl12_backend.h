// The fixed-function path: OpenGL 1.2, and the two block-compression extensions where the host allows them
// and the context has them. This file and its .cpp see no newer name, as gl12_table.h has none. GL thread,
// the context current.
#pragma once

#include "runtime/gl_textures.h"
#include "runtime/paging.h"

namespace vt::runtime {

class Gl12Backend {
 public:
  [[nodiscard]] Result<void> load(const GlHost& host, GlTextures& textures);
  // What the loader shall deliver for a layer's format, and how GL takes it. One channel becomes luminance,
  // two luminance and alpha. Blocks that the card does not take are decoded. kUnsupported for numbers beyond
  // 0 to 1, which OpenGL 1.2 has no textures for.
  struct Upload {
    TexelFormat format = TexelFormat::kRgb8;
    GlPixelFormat pixel;
  };
  [[nodiscard]] Result<Upload> upload_for(TexelFormat layer_format, bool must_be_plain) const;
  void bind(GlTextures& textures, unsigned texture, bool already_bound, const TileMatrix& matrix) const;

 private:
  gl12::MatrixFunctions gl_;
  bool compressed_ = false;
};

}  // namespace vt::runtime
