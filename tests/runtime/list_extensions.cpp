// Prints the extensions of a compatibility context, one a line. Exit code 77 when there is none.
#include <cstdio>
#include <string>

#include "runtime/gl12_table.h"
#include "tools/vtrender/egl_context.h"

int main() {
  namespace gl12 = vt::runtime::gl12;
  const auto context = vt::tools::EglContext::create(16, 16);
  gl12::TextureFunctions gl;
  if (!context || gl.load(vt::tools::EglContext::getproc, nullptr) != nullptr) return 77;
  std::string names = reinterpret_cast<const char*>(gl.GetString(gl12::GL_EXTENSIONS));
  for (char& c : names)
    if (c == ' ') c = '\n';
  std::puts(names.c_str());
}
