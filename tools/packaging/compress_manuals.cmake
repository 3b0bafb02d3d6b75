# Debian packages hold compressed manual pages. Run by cpack on the tree that it is about to pack; no time
# stamps, so that equal trees make equal packages.
file(GLOB_RECURSE manuals ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*.1)
list(FILTER manuals INCLUDE REGEX "/man/man1/")
foreach(manual IN LISTS manuals)
  execute_process(COMMAND gzip -9nf ${manual} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
