#!/usr/bin/env bash
# install_tree.sh BUILD PREFIX: installs a build, and moves the tree, as nothing in it may remember where it
# was laid first.
set -euo pipefail
build="$1" prefix="$2"
rm -rf "$prefix" "$prefix.first"
cmake --install "$build" --prefix "$prefix.first" >/dev/null
mv "$prefix.first" "$prefix"

if grep -rlI "$prefix.first" "$prefix"; then
  echo "these files name the folder that they were first installed in"
  exit 1
fi
if grep -rl --include='*.cmake' --include='*.pc' -e "$build" -e /usr/lib "$prefix"; then
  echo "these files name folders of the machine that they were built on"
  exit 1
fi
