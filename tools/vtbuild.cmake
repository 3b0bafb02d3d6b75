vt_program(vtbuild
  SOURCES vtbuild.cpp build_layer_command.cpp build_dataset_command.cpp build_sample_command.cpp build_pack_command.cpp build_remove_command.cpp build_common.cpp build_plan.cpp build_recipe.cpp build_report.cpp build_update_command.cpp
  LINKS vt_cli vt_pipeline vt_sample CLI11::CLI11 fmt::fmt)
target_compile_definitions(vtbuild PRIVATE VT_VERSION="${PROJECT_VERSION}")
