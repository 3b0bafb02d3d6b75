# What the commands that build layers ask for and print, apart from the program: vtinspect asks what a layer was built with.
vt_room(vt_build_commands
  SOURCES build_common.cpp build_dataset_command.cpp build_layer_command.cpp build_plan.cpp build_recipe.cpp build_report.cpp built_request.cpp
  LINKS PUBLIC vt_cli vt_pipeline CLI11::CLI11 PRIVATE vt_text fmt::fmt)

vt_program(vtbuild
  SOURCES vtbuild.cpp build_sample_command.cpp build_pack_command.cpp build_remove_command.cpp build_update_command.cpp
  LINKS vt_build_commands vt_cli vt_pipeline vt_sample CLI11::CLI11 fmt::fmt)
target_compile_definitions(vtbuild PRIVATE VT_VERSION="${PROJECT_VERSION}")
