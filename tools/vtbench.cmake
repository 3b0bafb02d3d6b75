# The measuring tools apart from the program, for their tests.
vt_room(vt_bench
  SOURCES bench_child.cpp bench_index.cpp bench_reference.cpp bench_support.cpp bench_svg.cpp bench_table.cpp bench_tiled_tiff.cpp
  LINKS PUBLIC vt_cli vt_channels vt_geo vt_store nlohmann_json::nlohmann_json PRIVATE fmt::fmt)

vt_program(vtbench
  SOURCES vtbench.cpp bench_accuracy_command.cpp bench_accuracy_scene.cpp bench_build_command.cpp bench_build_contenders.cpp bench_build_measure.cpp
          bench_build_report.cpp bench_channels_command.cpp bench_frame_command.cpp bench_key_value.cpp bench_lmdb.cpp bench_lookup_command.cpp bench_mosaic_command.cpp
          bench_parts.cpp bench_pool.cpp bench_scoreboard.cpp bench_scoreboard_command.cpp bench_sizes_command.cpp bench_sources_command.cpp bench_sqlite.cpp
  LINKS vt_bench vt_cli vt_pipeline vt_sample CLI11::CLI11 fmt::fmt)
target_compile_definitions(vtbench PRIVATE VT_VERSION="${PROJECT_VERSION}")

# Key-value stores to measure beside our index, where their headers are installed.
find_path(VT_LMDB_INCLUDE lmdb.h)
find_library(VT_LMDB_LIBRARY lmdb)
if(VT_LMDB_INCLUDE AND VT_LMDB_LIBRARY)
  target_include_directories(vtbench PRIVATE ${VT_LMDB_INCLUDE})
  target_link_libraries(vtbench PRIVATE ${VT_LMDB_LIBRARY})
  target_compile_definitions(vtbench PRIVATE VT_HAS_LMDB)
endif()
find_package(SQLite3)
if(SQLite3_FOUND)
  target_link_libraries(vtbench PRIVATE SQLite::SQLite3)
  target_compile_definitions(vtbench PRIVATE VT_HAS_SQLITE)
endif()
