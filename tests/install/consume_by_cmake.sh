#!/usr/bin/env bash
# consume_by_cmake.sh static|shared CONSUMER PREFIX STORE WORK: configures and builds a project against the
# installed tree, and runs it.
set -euo pipefail
kind="$1" consumer="$2" prefix="$3" store="$4" work="$5"
rm -rf "$work"
shared=OFF
[[ "$kind" == static ]] || shared=ON
cmake -G Ninja -S "$consumer" -B "$work" -DCMAKE_PREFIX_PATH="$prefix" -DBUILD_SHARED_LIBS=$shared >"$work.log" || { cat "$work.log"; exit 1; }

# Our flags are ours: a consumer compiles with its own.
ninja -C "$work" -t commands consumer >"$work.commands"
if grep -E -e ' -W| -ffp-contract' <(grep -e ' -c .*main\.cpp' "$work.commands"); then
  echo "vt::store brings warnings or code generation flags along"
  exit 1
fi
cmake --build "$work"

needed="$(readelf -d "$work/consumer" "$work/runtime_consumer" | grep -c 'NEEDED.*libvt_' || true)"
[[ "$kind" == static && "$needed" == 0 || "$kind" == shared && "$needed" -ge 2 ]] ||
  { echo "the programs need $needed shared libraries of ours, asked was $kind"; exit 1; }

"$work/consumer" "$store" >"$work/layers"
grep -qx 'rgb8: 16 x 16 texels, first byte [0-9]*' "$work/layers" || { cat "$work/layers"; exit 1; }
"$work/runtime_consumer" "$store" rgb8 >"$work/shader"
grep -q 'vec4 ground(vec2' "$work/shader" || { cat "$work/shader"; exit 1; }
cat "$work/layers"
