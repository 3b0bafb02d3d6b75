# The measuring tools apart from the program, for their tests.
vt_room(vt_bench
  SOURCES bench_child.cpp bench_reference.cpp bench_support.cpp bench_svg.cpp bench_table.cpp bench_tiled_tiff.cpp
  LINKS PUBLIC vt_cli vt_channels vt_geo vt_store nlohmann_json::nlohmann_json PRIVATE fmt::fmt)

vt_program(vtbench
  SOURCES vtbench.cpp bench_accuracy_command.cpp bench_accuracy_scene.cpp bench_build_command.cpp bench_build_contenders.cpp bench_build_measure.cpp
          bench_build_report.cpp bench_frame_command.cpp bench_lookup_command.cpp bench_mosaic_command.cpp bench_parts.cpp bench_pool.cpp
          bench_sizes_command.cpp bench_sources_command.cpp
  LINKS vt_bench vt_cli vt_pipeline vt_sample CLI11::CLI11 fmt::fmt)
target_compile_definitions(vtbench PRIVATE VT_VERSION="${PROJECT_VERSION}")
