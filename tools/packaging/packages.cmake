# `cpack` in a build folder makes two Debian packages: vt-tools, the programs, and libvt-dev, the libraries
# with what one builds against them.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME vt)
set(CPACK_PACKAGE_VENDOR vt)
set(CPACK_PACKAGE_CONTACT "vt maintainers <maintainers@vt.invalid>" CACHE STRING "Who answers for the packages: name <address>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL tools development)
set(CPACK_COMPONENTS_GROUPING IGNORE)  # a package for each component
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/tools/packaging/compress_manuals.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # dpkg-shlibdeps names the packages of the libraries that a file links
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME vt-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION graphics)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "Virtual-texture builder and its companions
vtbuild makes tile stores from georeferenced rasters, vtinspect shows, checks,
compares and extracts them, vtrender draws them without a window.")
# vtrender draws on any OpenGL driver that EGL finds.
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS libgl1-mesa-dri)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libvt-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Virtual-texture tile store and OpenGL runtime: libraries and headers
The store library reads and writes tile stores, the runtime library streams
them into OpenGL textures. Shared and static, with CMake and pkg-config files.")
# Headers of ours include tl/expected.hpp; the static library links the other two.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libexpected-dev, libzstd-dev, libxxhash-dev")
# A library built without the tools packs alone.
if(NOT VT_BUILD_BUILDER)
  set(CPACK_COMPONENTS_ALL development)
endif()
include(CPack)
