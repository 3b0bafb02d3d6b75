# What `cmake --install` lays down and cpack packs, in three components: `tools` (programs, manual pages,
# completions, schemas), `development` (the two libraries, both kinds, with headers and packages for CMake and
# pkg-config; vt_library() adds those parts itself) and `bench` (vtbench, where it was built; in no Debian
# package).
include(CMakePackageConfigHelpers)

# --- development ---
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/vt)
configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/cmake/vtConfig.cmake.in ${PROJECT_BINARY_DIR}/generated/vtConfig.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/generated/vtConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/generated/vtConfig.cmake ${PROJECT_BINARY_DIR}/generated/vtConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/tools/cmake/FindxxHash.cmake DESTINATION ${package_folder} COMPONENT development)
foreach(kind static shared)
  install(EXPORT vtTargets-${kind} NAMESPACE vt:: DESTINATION ${package_folder} COMPONENT development)
endforeach()

# pkg-config finds the prefix from where its file lies, so that the installed tree may move.
set(pkgconfig_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH VT_PREFIX_FROM_PKGCONFIG /p/${pkgconfig_folder} /p)
string(REGEX REPLACE "/$" "" VT_PREFIX_FROM_PKGCONFIG "${VT_PREFIX_FROM_PKGCONFIG}")
foreach(library store runtime)
  configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/vt-${library}.pc.in ${PROJECT_BINARY_DIR}/generated/vt-${library}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/generated/vt-${library}.pc DESTINATION ${pkgconfig_folder} COMPONENT development)
endforeach()

# Builds all that the components `tools` and `development` hold, and no tests or measuring tools.
add_custom_target(vt_installed)
add_dependencies(vt_installed vt_store vt_store_shared vt_runtime vt_runtime_shared)

# --- tools ---
if(VT_BUILD_BUILDER)
  find_package(Python3 COMPONENTS Interpreter REQUIRED)
  set(pages "")
  foreach(program vtbuild vtinspect vtrender)
    if(NOT TARGET ${program})
      continue()
    endif()
    install(TARGETS ${program} RUNTIME COMPONENT tools)
    add_dependencies(vt_installed ${program})
    set(manual ${PROJECT_BINARY_DIR}/share/man/man1/${program}.1)
    set(completion ${PROJECT_BINARY_DIR}/share/bash-completion/completions/${program})
    add_custom_command(OUTPUT ${manual} ${completion}
      COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/packaging/help_pages.py --version ${PROJECT_VERSION} $<TARGET_FILE:${program}> ${manual} ${completion}
      DEPENDS ${program} ${PROJECT_SOURCE_DIR}/tools/packaging/help_pages.py
      COMMENT "Manual page and completion of ${program}" VERBATIM)
    install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools)
    install(FILES ${completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT tools)
    list(APPEND pages ${manual} ${completion})
  endforeach()
  add_custom_target(vt_help_pages ALL DEPENDS ${pages})
  add_dependencies(vt_installed vt_help_pages vt_pictures)
  # Where builder/source/picture/picture_module.cpp looks for it, from the programs' folder.
  install(TARGETS vt_pictures LIBRARY DESTINATION lib/vt COMPONENT tools)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/schemas/ DESTINATION ${CMAKE_INSTALL_DATADIR}/vt/schemas COMPONENT tools
    FILES_MATCHING PATTERN *.json PATTERN tile-store.md)
  install(TARGETS vtbench RUNTIME COMPONENT bench OPTIONAL)
endif()

include(${PROJECT_SOURCE_DIR}/tools/packaging/packages.cmake)
