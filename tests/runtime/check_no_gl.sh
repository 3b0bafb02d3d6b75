#!/bin/sh
# check_no_gl.sh LIBRARY: fails when the archive needs an OpenGL, EGL or GLX symbol from the linker.
names=$(nm --undefined-only "$1") || exit 2
if echo "$names" | grep -E ' (gl|egl|glX)[A-Z]'; then
  echo "$1 must reach OpenGL through the host's getproc only"
  exit 1
fi
