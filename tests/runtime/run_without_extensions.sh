#!/bin/sh
# run_without_extensions.sh TEST_PROGRAM LIST_PROGRAM: the fixed-function tests on a driver that calls itself OpenGL 1.2 and lists no extension.
# Mesa hides names by MESA_EXTENSION_OVERRIDE="-GL_a -GL_b ..."; the names come from the driver itself.
names=$("$2") || exit 77
override=""
for name in $names; do override="$override -$name"; done
MESA_EXTENSION_OVERRIDE="$override" MESA_GL_VERSION_OVERRIDE=1.2 VT_EXPECT_GL=1.2 "$1" --gtest_filter='Gl12.*:Gl12OnOldDriver.*'
