#include "runtime/gl_formats.h"

#include <array>

#include "runtime/glsl_table.h"

namespace vt::runtime {
namespace {

using namespace gl12;
using namespace glsl;

constexpr GlPixelFormat plain(unsigned internal, unsigned channels, unsigned type) {
  return {.internal = internal, .format = channels, .type = type, .compressed = false};
}
constexpr GlPixelFormat blocks(unsigned internal) { return {.internal = internal, .format = 0, .type = 0, .compressed = true}; }
constexpr GlPixelFormat kNone;

// A format that is the same in both.
constexpr GlFormat alike(TexelFormat format, const GlPixelFormat& pixel) {
  return {.format = format, .fixed = pixel, .shader = pixel, .blocks = BlockSupport::kNotBlocks};
}

constexpr std::array kGlFormats = {
    alike(TexelFormat::kRgb8, plain(GL_RGB8, gl12::GL_RGB, GL_UNSIGNED_BYTE)),
    alike(TexelFormat::kRgba8, plain(GL_RGBA8, gl12::GL_RGBA, GL_UNSIGNED_BYTE)),
    GlFormat{TexelFormat::kBc1, blocks(GL_COMPRESSED_RGB_S3TC_DXT1_EXT), blocks(GL_COMPRESSED_RGB_S3TC_DXT1_EXT), BlockSupport::kS3tc},
    GlFormat{TexelFormat::kR32Float, kNone, plain(GL_R32F, gl12::GL_RED, gl12::GL_FLOAT)},
    GlFormat{TexelFormat::kRg32Float, kNone, plain(GL_RG32F, GL_RG, gl12::GL_FLOAT)},
    GlFormat{TexelFormat::kRgba32Float, kNone, plain(GL_RGBA32F, gl12::GL_RGBA, gl12::GL_FLOAT)},
    GlFormat{TexelFormat::kR8, plain(GL_LUMINANCE8, GL_LUMINANCE, GL_UNSIGNED_BYTE), plain(GL_R8, gl12::GL_RED, GL_UNSIGNED_BYTE)},
    GlFormat{TexelFormat::kRg8, plain(GL_LUMINANCE8_ALPHA8, GL_LUMINANCE_ALPHA, GL_UNSIGNED_BYTE), plain(GL_RG8, GL_RG, GL_UNSIGNED_BYTE)},
    GlFormat{TexelFormat::kR16, plain(GL_LUMINANCE16, GL_LUMINANCE, GL_UNSIGNED_SHORT), plain(GL_R16, gl12::GL_RED, GL_UNSIGNED_SHORT)},
    GlFormat{TexelFormat::kRg16, plain(GL_LUMINANCE16_ALPHA16, GL_LUMINANCE_ALPHA, GL_UNSIGNED_SHORT),
             plain(GL_RG16, GL_RG, GL_UNSIGNED_SHORT)},
    alike(TexelFormat::kRgba16, plain(GL_RGBA16, gl12::GL_RGBA, GL_UNSIGNED_SHORT)),
    GlFormat{TexelFormat::kR16Float, kNone, plain(GL_R16F, gl12::GL_RED, GL_HALF_FLOAT)},
    GlFormat{TexelFormat::kRg16Float, kNone, plain(GL_RG16F, GL_RG, GL_HALF_FLOAT)},
    GlFormat{TexelFormat::kRgba16Float, kNone, plain(GL_RGBA16F, gl12::GL_RGBA, GL_HALF_FLOAT)},
    GlFormat{TexelFormat::kRgb9e5, kNone, plain(GL_RGB9_E5, gl12::GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV)},
    GlFormat{TexelFormat::kBc3, blocks(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT), blocks(GL_COMPRESSED_RGBA_S3TC_DXT5_EXT), BlockSupport::kS3tc},
    GlFormat{TexelFormat::kBc4, kNone, blocks(GL_COMPRESSED_RED_RGTC1), BlockSupport::kRgtc},
    GlFormat{TexelFormat::kBc5, kNone, blocks(GL_COMPRESSED_RG_RGTC2), BlockSupport::kRgtc},
    GlFormat{TexelFormat::kBc6h, kNone, blocks(GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT_ARB), BlockSupport::kBptc},
    GlFormat{TexelFormat::kBc7, kNone, blocks(GL_COMPRESSED_RGBA_BPTC_UNORM_ARB), BlockSupport::kBptc},
};
static_assert(has_one_row_each(kGlFormats, has_samples));

}  // namespace

const GlFormat& gl_format(TexelFormat format) { return row_of(kGlFormats, format); }

}  // namespace vt::runtime
