#!/usr/bin/env bash
# embed.sh CONSUMER SOURCES WORK: a project with our sources as a sub-folder gets our libraries and none of
# our flags, programs or tests.
set -euo pipefail
consumer="$1" sources="$2" work="$3"
rm -rf "$work"
cmake -G Ninja -S "$consumer" -B "$work" -DVT_SOURCE="$sources" >"$work.log" || { cat "$work.log"; exit 1; }
ninja -C "$work" -t commands all >"$work.commands"
say() { echo "$*"; exit 1; }

if grep -E -e ' -W| -ffp-contract' <(grep -e "-c $consumer/main.cpp" "$work.commands"); then say "the consumer is compiled with our flags"; fi
grep -q -e '-ffp-contract=off' <<<"$(grep -F "$sources/store/region.cpp" "$work.commands")" || say "our files are compiled without our flags"
if grep -F "$sources/store/region.cpp" "$work.commands" | grep -e '-Werror'; then say "warnings of another compiler are errors"; fi
if grep -E "$sources/(tools|builder)/|-c $sources/tests/(store|runtime|support)|libvt_store\.so" "$work.commands"; then say "more is built than was asked for"; fi
if grep -rl --include=cmake_install.cmake include/vt "$work"; then say "installing the other project would install ours"; fi
