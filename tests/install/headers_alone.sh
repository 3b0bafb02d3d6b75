#!/usr/bin/env bash
# headers_alone.sh COMPILER FOLDER: every installed header compiles as the only one of a file, with warnings,
# and includes only what is installed.
set -euo pipefail
compiler="$1" folder="$2"
cd "$folder"
headers="$(find . -name '*.h' -printf '%P\n' | sort)"
[[ "$(wc -l <<<"$headers")" -ge 10 ]] || { echo "only these headers are installed: $headers"; exit 1; }
failed=0
for header in $headers; do
  echo "#include \"$header\"" |
    "$compiler" -std=c++20 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I "$folder" -x c++ - || { echo "$header does not compile alone"; failed=1; }
done
exit $failed
