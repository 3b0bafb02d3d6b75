// An OpenGL 1.2 that only remembers: textures are arrays in memory, bindings and matrices are variables. Any
// other name is refused and counted. Lets the whole runtime be tested, under the thread sanitizer too, and
// shows what a real GL hides: what lies in a texture that is being filled.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "runtime/gl12_table.h"
#include "runtime/virtual_texture.h"

namespace vt::runtime::test {

class FakeGl {
 public:
  struct Mip {
    int width = 0;
    int channels = 0;
    std::vector<std::uint8_t> texels;
  };

  FakeGl() { current_ = this; }
  ~FakeGl() { current_ = nullptr; }
  FakeGl(const FakeGl&) = delete;
  FakeGl& operator=(const FakeGl&) = delete;

  [[nodiscard]] GlHost host() { return {.getproc = getproc, .user = this, .path = Path::kFixedFunction, .allow_extensions = false}; }

  std::map<unsigned, std::map<int, Mip>> textures;
  unsigned bound = 0;
  std::array<double, 16> matrix{};
  int matrix_mode = 0x1700;
  std::map<unsigned, int> pixel_store{{gl12::GL_UNPACK_ALIGNMENT, 4}, {gl12::GL_UNPACK_ROW_LENGTH, 7}};
  std::set<std::string> refused;
  std::size_t uploaded_bytes = 0;
  int upload_calls = 0;
  bool bad_upload = false;

 private:
  using E = gl12::GLenum;
  using I = gl12::GLint;
  inline static FakeGl* current_ = nullptr;
  unsigned next_name_ = 1;

  static void bind_texture(E, unsigned texture) { current_->bound = texture; }
  static void delete_textures(I count, const unsigned* names) {
    for (I i = 0; i < count; ++i) current_->textures.erase(names[i]);
  }
  static void gen_textures(I count, unsigned* names) {
    for (I i = 0; i < count; ++i) names[i] = current_->next_name_++;
  }
  static E get_error() { return 0; }
  static void get_integer(E name, I* value) {
    if (name == gl12::GL_MAX_TEXTURE_SIZE) *value = 4096;
    if (name == gl12::GL_TEXTURE_BINDING_2D) *value = static_cast<I>(current_->bound);
    if (name == gl12::GL_MATRIX_MODE) *value = current_->matrix_mode;
    const auto found = current_->pixel_store.find(name);
    if (found != current_->pixel_store.end()) *value = found->second;
  }
  static const unsigned char* get_string(E name) {
    return reinterpret_cast<const unsigned char*>(name == gl12::GL_VERSION ? "1.2 fake" : "");
  }
  static void pixel_store_i(E name, I value) { current_->pixel_store[name] = value; }
  static void tex_image(E, I mip, I, I width, I, I, E format, E, const void*) {
    const int channels = format == gl12::GL_RGB ? 3 : 4;
    current_->textures[current_->bound][mip] = {width, channels,
                                                std::vector<std::uint8_t>(static_cast<std::size_t>(width * width * channels), 0xEE)};
  }
  static void tex_parameter(E, E, I) {}
  static void tex_sub_image(E, I mip, I x, I y, I width, I height, E, E, const void* texels) {
    Mip& target = current_->textures[current_->bound][mip];
    current_->bad_upload |= current_->pixel_store[gl12::GL_UNPACK_ALIGNMENT] != 1 || current_->pixel_store[gl12::GL_UNPACK_ROW_LENGTH] != 0;
    current_->bad_upload |= x < 0 || y < 0 || x + width > target.width || y + height > target.width;
    if (current_->bad_upload) return;
    const auto row = static_cast<std::size_t>(width * target.channels);
    for (I j = 0; j < height; ++j)
      std::memcpy(target.texels.data() + static_cast<std::size_t>(((y + j) * target.width + x) * target.channels),
                  static_cast<const std::uint8_t*>(texels) + static_cast<std::size_t>(j) * row, row);
    current_->uploaded_bytes += row * static_cast<std::size_t>(height);
    ++current_->upload_calls;
  }
  static void load_matrix(const double* m) { std::copy(m, m + 16, current_->matrix.begin()); }
  static void matrix_mode_(E mode) { current_->matrix_mode = static_cast<int>(mode); }

  static void* getproc(const char* name, void* user) {
    static const std::map<std::string, void*> kKnown = {
        {"glBindTexture", reinterpret_cast<void*>(bind_texture)},    {"glDeleteTextures", reinterpret_cast<void*>(delete_textures)},
        {"glGenTextures", reinterpret_cast<void*>(gen_textures)},    {"glGetError", reinterpret_cast<void*>(get_error)},
        {"glGetIntegerv", reinterpret_cast<void*>(get_integer)},     {"glGetString", reinterpret_cast<void*>(get_string)},
        {"glPixelStorei", reinterpret_cast<void*>(pixel_store_i)},   {"glTexImage2D", reinterpret_cast<void*>(tex_image)},
        {"glTexParameteri", reinterpret_cast<void*>(tex_parameter)}, {"glTexSubImage2D", reinterpret_cast<void*>(tex_sub_image)},
        {"glLoadMatrixd", reinterpret_cast<void*>(load_matrix)},     {"glMatrixMode", reinterpret_cast<void*>(matrix_mode_)}};
    const auto found = kKnown.find(name);
    if (found != kKnown.end()) return found->second;
    static_cast<FakeGl*>(user)->refused.insert(name);
    return nullptr;
  }
};

}  // namespace vt::runtime::test
