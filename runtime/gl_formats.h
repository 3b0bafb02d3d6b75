// How OpenGL takes each texel format: one row a format. Names newer than OpenGL 1.2 are in the .cpp only, so
// that the fixed-function path can include this. Plain values, any thread.
#pragma once

#include "runtime/gl_textures.h"
#include "store/texel_format.h"

namespace vt::runtime {

// What a context must have beside its version to take a format's blocks.
enum class BlockSupport {
  kNotBlocks,
  kS3tc,
  kRgtc,
  kBptc,
};

struct GlFormat {
  TexelFormat format;
  // In OpenGL 1.2 and, of blocks, its extensions: one channel is luminance, two are luminance and alpha.
  // is_none() where it has none.
  GlPixelFormat fixed;
  // In OpenGL 3.0 and, of blocks, its extensions.
  GlPixelFormat shader;
  BlockSupport blocks = BlockSupport::kNotBlocks;
};

// The row of a format with samples.
[[nodiscard]] const GlFormat& gl_format(TexelFormat format);

}  // namespace vt::runtime
