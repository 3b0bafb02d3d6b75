# vt_egl: an OpenGL context without a window system, for vtrender and the OpenGL tests. Only where EGL is found.
include_guard(GLOBAL)
find_package(OpenGL COMPONENTS EGL)
if(OpenGL_EGL_FOUND)
  add_library(vt_egl STATIC ${PROJECT_SOURCE_DIR}/tools/vtrender/egl_context.cpp)
  target_link_libraries(vt_egl PUBLIC vt_flags tl::expected PRIVATE OpenGL::EGL)
endif()
