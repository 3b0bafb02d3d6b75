#include "tools/vtrender/egl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <string>
#include <utility>

namespace vt::tools {
namespace {

tl::unexpected<Error> no_context(const char* step) {
  return fail(ErrorCode::kUnsupported, std::string("no OpenGL context without a window: ") + step + " failed (EGL error " +
                                           std::to_string(eglGetError()) + "); Debian needs libegl-mesa0 and libgl1-mesa-dri");
}

}  // namespace

Result<EglContext> EglContext::create(int width, int height, GlProfile profile) {
  const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) return no_context("eglGetPlatformDisplayEXT");
  EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return no_context("eglInitialize");
  if (!eglBindAPI(EGL_OPENGL_API)) return no_context("eglBindAPI");

  const EGLint wanted[] = {EGL_SURFACE_TYPE,
                           EGL_PBUFFER_BIT,
                           EGL_RENDERABLE_TYPE,
                           EGL_OPENGL_BIT,
                           EGL_RED_SIZE,
                           8,
                           EGL_GREEN_SIZE,
                           8,
                           EGL_BLUE_SIZE,
                           8,
                           EGL_ALPHA_SIZE,
                           8,
                           EGL_DEPTH_SIZE,
                           24,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &count) || count == 0) return no_context("eglChooseConfig");

  EglContext made;
  made.display_ = display;
  const EGLint size[] = {EGL_WIDTH, width, EGL_HEIGHT, height, EGL_NONE};
  made.surface_ = eglCreatePbufferSurface(display, config, size);
  if (made.surface_ == EGL_NO_SURFACE) return no_context("eglCreatePbufferSurface");
  const EGLint core[] = {EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  made.context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, profile == GlProfile::kCore33 ? core : nullptr);
  if (made.context_ == EGL_NO_CONTEXT) return no_context("eglCreateContext");
  if (!eglMakeCurrent(display, made.surface_, made.surface_, made.context_)) return no_context("eglMakeCurrent");
  return made;
}

EglContext::EglContext(EglContext&& other) noexcept { *this = std::move(other); }

EglContext& EglContext::operator=(EglContext&& other) noexcept {
  std::swap(display_, other.display_);
  std::swap(surface_, other.surface_);
  std::swap(context_, other.context_);
  return *this;
}

EglContext::~EglContext() {
  if (display_ == nullptr) return;
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (context_ != nullptr) eglDestroyContext(display_, context_);
  if (surface_ != nullptr) eglDestroySurface(display_, surface_);
}

void* EglContext::getproc(const char* name, void*) { return reinterpret_cast<void*>(eglGetProcAddress(name)); }

}  // namespace vt::tools
