// An OpenGL context without a window system: EGL's surfaceless platform with a pbuffer. For vtrender and the
// tests; the runtime library makes no context. The context is current on the thread that made it. The display
// stays open until the process ends (closing it makes Mesa look like a leak).
#pragma once

#include "store/result.h"

namespace vt::tools {

enum class GlProfile {
  kCompatibility,  // asked for without a version, so that version overrides of the driver work too
  kCore33,
};

class EglContext {
 public:
  // kUnsupported when there is no EGL surfaceless driver; the message names the packages.
  [[nodiscard]] static Result<EglContext> create(int width, int height, GlProfile profile = GlProfile::kCompatibility);
  EglContext(EglContext&& other) noexcept;
  EglContext& operator=(EglContext&& other) noexcept;
  ~EglContext();

  // For GlHost::getproc and the tables of gl_table.h; `user` is not used.
  [[nodiscard]] static void* getproc(const char* name, void* user);

 private:
  EglContext() = default;
  void* display_ = nullptr;
  void* surface_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace vt::tools
