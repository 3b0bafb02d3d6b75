include(${PROJECT_SOURCE_DIR}/tools/egl_context.cmake)
if(TARGET vt_egl)
  vt_program(vtrender
    SOURCES vtrender.cpp vtrender_scene.cpp
    LINKS vt_runtime vt_geo vt_egl vt_cli vt_picture_writer nlohmann_json::nlohmann_json CLI11::CLI11 fmt::fmt)
else()
  message(STATUS "EGL was not found: vtrender is not built")
endif()
