#include "tests/encode/opengl_decoder.h"

#include <cstdlib>

#if VT_HAVE_EGL
#include "tools/vtrender/egl_context.h"
#endif

namespace vt::encode {

#if VT_HAVE_EGL
namespace {

using Enum = unsigned;
constexpr Enum kTexture2d = 0x0DE1, kRgba = 0x1908, kFloat = 0x1406, kPackAlignment = 0x0D05;

template <typename Function>
Function* function(const char* name) {
  return reinterpret_cast<Function*>(tools::EglContext::getproc(name, nullptr));
}

}  // namespace

std::optional<std::vector<float>> decoded_by_opengl(GlBlockFormat format, std::span<const std::byte> blocks, std::size_t width,
                                                    std::size_t height, std::string& why) {
  // The one of Mesa's two software drivers that decodes in whole numbers; the other interpolates with weights
  // of 8 bits and is up to 1.6 codes away from the specification. Drivers of hardware do not look at this.
  setenv("GALLIUM_DRIVER", "softpipe", 0);
  const auto context = tools::EglContext::create(16, 16);
  if (!context) {
    why = context.error().message;
    return std::nullopt;
  }
  const auto gen_textures = function<void(int, unsigned*)>("glGenTextures");
  const auto delete_textures = function<void(int, const unsigned*)>("glDeleteTextures");
  const auto bind_texture = function<void(Enum, unsigned)>("glBindTexture");
  const auto compressed_image = function<void(Enum, int, Enum, int, int, int, int, const void*)>("glCompressedTexImage2D");
  const auto pixel_store = function<void(Enum, int)>("glPixelStorei");
  const auto get_image = function<void(Enum, int, Enum, Enum, void*)>("glGetTexImage");
  const auto get_error = function<Enum()>("glGetError");
  unsigned texture = 0;
  gen_textures(1, &texture);
  bind_texture(kTexture2d, texture);
  pixel_store(kPackAlignment, 1);
  compressed_image(kTexture2d, 0, static_cast<Enum>(format), static_cast<int>(width), static_cast<int>(height), 0,
                   static_cast<int>(blocks.size()), blocks.data());
  std::vector<float> texels(width * height * 4);
  get_image(kTexture2d, 0, kRgba, kFloat, texels.data());
  const Enum error = get_error();
  delete_textures(1, &texture);
  if (error != 0) {
    why = "OpenGL error " + std::to_string(error) + " on a texture of blocks";
    return std::nullopt;
  }
  return texels;
}
#else
std::optional<std::vector<float>> decoded_by_opengl(GlBlockFormat, std::span<const std::byte>, std::size_t, std::size_t, std::string& why) {
  why = "built without EGL (libegl-dev)";
  return std::nullopt;
}
#endif

}  // namespace vt::encode
