// Opens a virtual texture of a store's layer and prints the shader function for it: what works before there
// is an OpenGL context.
#include <cstdio>

#include "runtime/virtual_texture.h"

int main(int argc, char** argv) {
  if (argc != 3) return 1;
  vt::runtime::Options options;
  options.layer = argv[2];
  const auto texture = vt::runtime::VirtualTexture::open(argv[1], options);
  if (!texture) {
    std::fprintf(stderr, "%s\n", texture.error().message.c_str());
    return 2;
  }
  std::printf("%s\n%s\n", texture->layer().name.c_str(), vt::runtime::VirtualTexture::glsl_function("ground", 2).c_str());
}
