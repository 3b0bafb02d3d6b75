# One way to declare a part, a library that others embed, a program and a test, so that flags are said once.

# How our own files are compiled. Every target of ours links it privately: whoever embeds a library compiles
# with flags of their own.
add_library(vt_flags INTERFACE)
target_include_directories(vt_flags INTERFACE ${PROJECT_SOURCE_DIR})
# Options are plain structs with defaults, set by designated initialisers: fields left out are meant to be.
target_compile_options(vt_flags INTERFACE -Wno-missing-field-initializers)
# VT_MAY_SHADOW: where a name may be that of the file before, see vt_together().
# Products and sums must round the same way on every CPU, or tiles would differ from machine to machine: no
# contraction into fused multiply-add.
target_compile_options(vt_flags INTERFACE -Wall -Wextra -Wpedantic $<$<NOT:$<BOOL:$<TARGET_PROPERTY:VT_MAY_SHADOW>>>:-Wshadow> $<$<BOOL:${VT_WARNINGS_ARE_ERRORS}>:-Werror> -ffp-contract=off)
# GCC 12 sees overlapping copies in std::string's own code (its bug 105651).
target_compile_options(vt_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(VT_SANITIZE)
  target_compile_options(vt_flags INTERFACE -fsanitize=${VT_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(vt_flags INTERFACE -fsanitize=${VT_SANITIZE})
  if(VT_SANITIZE STREQUAL "address")
    target_compile_options(vt_flags INTERFACE -fsanitize=undefined -fno-sanitize-recover=undefined)
    target_link_options(vt_flags INTERFACE -fsanitize=undefined)
  endif()
endif()
if(VT_FUZZ)
  target_compile_options(vt_flags INTERFACE -fsanitize=fuzzer-no-link,address,undefined)
  target_link_options(vt_flags INTERFACE -fsanitize=address,undefined)
endif()

# vt_together(vt_cli ...): compiles the targets' files several at a time, where parsing what they all include
# takes most of the time. The price is that names in their anonymous namespaces have to differ. Not in the
# preset runtime-only, where every file of the libraries shows that it includes what it needs.
option(VT_UNITY "Tests, tools and some libraries are compiled several files at a time" OFF)
function(vt_together)
  set_target_properties(${ARGN} PROPERTIES UNITY_BUILD ${VT_UNITY} UNITY_BUILD_BATCH_SIZE 8 VT_MAY_SHADOW ${VT_UNITY})
endfunction()

# vt_part(vt_geo SOURCES a.cpp ... LINKS PUBLIC|PRIVATE ...)
function(vt_part name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_include_directories(${name} INTERFACE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE vt_flags PUBLIC ${ARG_LINKS})
endfunction()

# vt_library(vt_store SOURCES a.cpp ... HEADERS store/a.h ... EXPORTS vt::store::pack* ... LINKS PUBLIC ...)
# A library that others embed. Its files are compiled once and linked twice: vt_store, static, which our
# programs and tests link, and vt_store_shared. vt::store is one of the two as BUILD_SHARED_LIBS says;
# vt::store_static and vt::store_shared name each.
# HEADERS, from the project's root, are what is installed. EXPORTS are the demangled names that the shared
# library shows, with the wildcards of a linker version script; all others stay inside.
function(vt_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;HEADERS;EXPORTS;LINKS" ${ARGN})
  string(REGEX REPLACE "^vt_" "" short ${name})

  add_library(${name}_objects OBJECT ${ARG_SOURCES})
  set(used ${ARG_LINKS})
  list(REMOVE_ITEM used PUBLIC PRIVATE)
  target_link_libraries(${name}_objects PRIVATE vt_flags ${used})

  add_library(${name} STATIC)
  add_library(${name}_shared SHARED)
  add_library(vt::${short}_static ALIAS ${name})
  add_library(vt::${short}_shared ALIAS ${name}_shared)
  if(BUILD_SHARED_LIBS)
    add_library(vt::${short} ALIAS ${name}_shared)
  else()
    add_library(vt::${short} ALIAS ${name})
  endif()

  # The shared library links the other shared libraries of ours.
  set(shared_links ${ARG_LINKS})
  list(TRANSFORM shared_links APPEND _shared REGEX "^vt_")
  target_link_libraries(${name} ${ARG_LINKS})
  target_link_libraries(${name}_shared ${shared_links})
  foreach(kind static shared)
    set(target ${name})
    if(kind STREQUAL shared)
      set(target ${name}_shared)
    endif()
    target_sources(${target} PRIVATE $<TARGET_OBJECTS:${name}_objects>)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/vt>)
    target_compile_features(${target} INTERFACE cxx_std_20)
    set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} EXPORT_NAME ${short}_${kind} LINKER_LANGUAGE CXX)
  endforeach()

  # Before version 1 every minor version may break what is built against it, and has a name of its own.
  set(interface ${PROJECT_VERSION_MAJOR})
  if(PROJECT_VERSION_MAJOR EQUAL 0)
    set(interface 0.${PROJECT_VERSION_MINOR})
  endif()
  string(TOUPPER ${name} node)
  list(JOIN ARG_EXPORTS ";\n    " exports)
  set(map ${PROJECT_BINARY_DIR}/generated/${name}.map)
  file(CONFIGURE OUTPUT ${map} @ONLY CONTENT
    "${node}_${interface} {\n  global: extern \"C++\" {\n    ${exports};\n  };\n  local: *;\n};\n")
  target_link_options(${name}_shared PRIVATE LINKER:--version-script=${map} LINKER:-Bsymbolic-functions)
  if(NOT VT_SANITIZE AND NOT VT_FUZZ)
    target_link_options(${name}_shared PRIVATE LINKER:--no-undefined)
  endif()
  set_target_properties(${name}_shared PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${interface} LINK_DEPENDS ${map}
    INSTALL_RPATH $ORIGIN LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)

  if(VT_INSTALL)
    install(TARGETS ${name} EXPORT vtTargets-static ARCHIVE COMPONENT development)
    install(TARGETS ${name}_shared EXPORT vtTargets-shared LIBRARY COMPONENT development NAMELINK_COMPONENT development)
    foreach(header IN LISTS ARG_HEADERS)
      cmake_path(GET header PARENT_PATH folder)
      install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/vt/${folder} COMPONENT development)
    endforeach()
  else()
    set_target_properties(${name}_shared PROPERTIES EXCLUDE_FROM_ALL TRUE)
  endif()
endfunction()

function(vt_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE vt_flags ${ARG_LINKS})
  vt_needs_pictures(${name})
endfunction()

# The library that programs load when they meet a picture.
function(vt_needs_pictures name)
  if(TARGET vt_pictures)
    add_dependencies(${name} vt_pictures)
  endif()
endfunction()

# vt_test(store_test SOURCES a_test.cpp ... LINKS vt_store [ENVIRONMENT A=b ...] [LABELS ...] [SERIAL]
# [TOGETHER])
# One program a folder; ctest sees every case. Test programs find real rasters through VT_TEST_DATA and skip,
# saying so, when it is not there.
# TOGETHER: see vt_together().
# VT_TESTS_SANITIZED, set in a folder: its tests read bytes from outside. They have the label `sanitized`, and
# `tools/dev test` builds and runs them under sanitizers.
function(vt_test name)
  cmake_parse_arguments(ARG "SERIAL;TOGETHER" "" "SOURCES;LINKS;ENVIRONMENT;LABELS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE vt_flags ${ARG_LINKS} GTest::gtest_main GTest::gmock)
  # Tests are compiled more often than they run: -O1 takes 60 % of the time of -O2 and is fast enough for plain
  # references. Under sanitizers -O0 takes half of the time of -O1: their checks multiply the code.
  if(NOT CMAKE_BUILD_TYPE)
    target_compile_options(${name} PRIVATE $<IF:$<BOOL:${VT_SANITIZE}>,-O0,-O1>)
  endif()
  vt_needs_pictures(${name})
  if(ARG_TOGETHER)
    vt_together(${name})
  endif()
  if(VT_TESTS_SANITIZED)
    list(APPEND ARG_LABELS sanitized)
    add_dependencies(sanitized_tests ${name})
  else()
    add_dependencies(other_tests ${name})
  endif()
  # The time-out is for tests that hang; a busy machine may take its time.
  set(serial)
  if(ARG_SERIAL)
    set(serial RUN_SERIAL TRUE)
  endif()
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 600 TEST_LIST cases_of_${name} PROPERTIES TIMEOUT 3600 ${serial})
  # Lists do not get through PROPERTIES: ctest gives them to the cases.
  if(ARG_ENVIRONMENT OR ARG_LABELS)
    set(script ${CMAKE_CURRENT_BINARY_DIR}/${name}_properties.cmake)
    file(CONFIGURE OUTPUT ${script} @ONLY CONTENT
      "if(cases_of_@name@)\n  set_tests_properties(\${cases_of_@name@} PROPERTIES ENVIRONMENT \"@ARG_ENVIRONMENT@\" LABELS \"@ARG_LABELS@\")\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${script})
  endif()
endfunction()
