#!/usr/bin/env bash
# consume_by_pkg_config.sh COMPILER CONSUMER LIBRARY_FOLDER STORE WORK: compiles the same programs with one
# plain line each.
set -euo pipefail
compiler="$1" consumer="$2" libraries="$3" store="$4" work="$5"
rm -rf "$work"
mkdir -p "$work"
export PKG_CONFIG_PATH="$libraries/pkgconfig" LD_LIBRARY_PATH="$libraries"

"$compiler" -std=c++20 "$consumer/main.cpp" -o "$work/consumer" $(pkg-config --cflags --libs vt-store)
"$compiler" -std=c++20 "$consumer/runtime_main.cpp" -o "$work/runtime_consumer" $(pkg-config --cflags --libs vt-runtime)
# The static library, with what pkg-config says that it needs beside.
"$compiler" -std=c++20 "$consumer/main.cpp" -o "$work/consumer_static" $(pkg-config --cflags vt-store) "$libraries/libvt_store.a" \
  $(pkg-config --static --libs vt-store | sed 's/-lvt_store//')

"$work/consumer" "$store" >"$work/layers"
"$work/consumer_static" "$store" >"$work/layers_static"
cmp "$work/layers" "$work/layers_static"
grep -q '^rgb8: 16 x 16 texels' "$work/layers" || { cat "$work/layers"; exit 1; }
grep -q 'vec4 ground(vec2' <<<"$("$work/runtime_consumer" "$store" rgb8)"
