include(${PROJECT_SOURCE_DIR}/tools/egl_context.cmake)
if(TARGET vt_egl)
  # Debian's OpenImageIO names an OpenCV folder that its own package does not bring; CMake refuses paths that do not exist.
  get_target_property(oiio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
  foreach(folder IN LISTS oiio_includes)
    if(IS_ABSOLUTE "${folder}" AND NOT EXISTS "${folder}")
      list(REMOVE_ITEM oiio_includes "${folder}")
    endif()
  endforeach()
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${oiio_includes}")

  vt_program(vtrender
    SOURCES vtrender.cpp vtrender_scene.cpp vtrender_png.cpp
    LINKS vt_runtime vt_geo vt_egl vt_cli nlohmann_json::nlohmann_json CLI11::CLI11 fmt::fmt OpenImageIO::OpenImageIO)
else()
  message(STATUS "EGL was not found: vtrender is not built")
endif()
