// The loop of an image generator as README.md shows it, so that what newcomers copy compiles. Only compiled,
// never run; cli/readme_test holds the text between the marks against the README.

// README: from here
#include "runtime/virtual_texture.h"
using namespace vt::runtime;
// README: to here

#include <vector>

namespace vt::test {

struct Patch {
  UvBox uv_box;
  Point2 uv_origin;
  void draw() const;
};
void* my_getproc(const char* name, void* user);
bool next_frame();
Point2 observer_uv();
bool draw_frames(const std::vector<Patch>& terrain);

bool draw_frames(const std::vector<Patch>& terrain) {
  // README: from here
  auto texture = VirtualTexture::open("scene.vts", {.layer = "color"});     // starts the loader thread
  if (!texture || !texture->attach({.getproc = my_getproc})) return false;  // OpenGL 1.2; your context is current
  while (next_frame()) {                                                    // on the drawing thread
    texture->set_center(observer_uv());                                     // (u, v); any thread, any time
    texture->update();                                                      // never more than the upload budget, never the disk
    for (const Patch& patch : terrain) {
      const StageSet tiles = texture->select(patch.uv_box);  // the tiles to draw it with
      texture->bind(tiles, patch.uv_origin);                 // the texture and its matrix
      patch.draw();                                          // texture coordinates are (u, v) - uv_origin
    }
  }
  // README: to here
  return true;
}

}  // namespace vt::test
