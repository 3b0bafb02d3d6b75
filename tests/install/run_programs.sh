#!/usr/bin/env bash
# run_programs.sh PREFIX WORK: the installed programs find what belongs to them, their manual pages are whole
# and their completions answer.
set -euo pipefail
prefix="$1" work="$2"
rm -rf "$work"
mkdir -p "$work"
cd "$work"
say() { echo "$*"; exit 1; }

# A picture goes through vt_pictures.so, which the programs load from the tree. 16 x 16 texels of one colour.
python3 - <<'PYTHON'
import struct, zlib
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
rows = b"".join(b"\0" + bytes((10, 20, 30)) * 16 for _ in range(16))
header = struct.pack(">IIBBBBB", 16, 16, 8, 2, 0, 0, 0)
open("in.png", "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
PYTHON
"$prefix/bin/vtbuild" layer in.png -o out.vts --channel color --crs pixel --progress none >/dev/null
"$prefix/bin/vtinspect" extract out.vts -o out.png --progress none >/dev/null
"$prefix/bin/vtinspect" validate out.vts --progress none >/dev/null
[[ -s out.png ]] || say "vtinspect wrote no picture"

schema="$prefix/share/vt/schemas/dataset.schema.json"
[[ -s "$schema" && -s "$prefix/share/vt/schemas/tile-store.md" ]] || say "schemas are missing"

programs=(vtbuild vtinspect)
[[ ! -x "$prefix/bin/vtrender" ]] || programs+=(vtrender)
for program in "${programs[@]}"; do
  manual="$prefix/share/man/man1/$program.1"
  [[ -s "$manual" ]] || say "$manual is missing"
  for word in SYNOPSIS OPTIONS EXAMPLES 'EXIT STATUS'; do
    grep -q "^\.SH \"*$word" "$manual" || say "$program.1 has no section $word"
  done
  if command -v groff >/dev/null; then
    complaints="$(groff -man -Tutf8 -ww -z "$manual" 2>&1)"
    [[ -z "$complaints" ]] || say "$complaints"
  fi
  # Every option of the program and its subcommands stands in the manual page.
  subcommands="$("$prefix/bin/$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')"
  for subcommand in '' $subcommands; do
    for option in $("$prefix/bin/$program" $subcommand --help | grep -oE '^ +(-[a-z],)?--[a-z-]+' | grep -oE -- '--[a-z-]+'); do
      grep -qF -- "${option//-/\\-}" "$manual" || say "$program.1 says nothing of $option"
    done
  done
done

# complete WORDS...: what the shell offers for the last word.
complete_words() {
  bash -c '
    source "$1/share/bash-completion/completions/$2"
    shift
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    "_$1"
    printf "%s\n" "${COMPREPLY[@]}"' complete "$prefix" "$@"
}
offers() {  # offers CANDIDATE WORDS...
  local candidate="$1" offered
  shift
  offered="$(complete_words "$@")"
  grep -qxF -- "$candidate" <<<"$offered" || say "completing '$*' does not offer $candidate, but: ${offered//$'\n'/ }"
}
offers layer vtbuild la
offers --channel vtbuild layer --ch
offers --azimuths vtbuild layer in.tif --az
offers elevation vtbuild layer in.tif --channel el
offers --keep-carry vtbuild pack a.vts --
offers --lonlat vtinspect sample base.vts --lo
offers plain vtinspect validate --progress p
[[ -z "$(complete_words vtbuild layer in)" ]] || say "files are left to the shell"
[[ -z "$(complete_words vtbuild remove --ch)" ]] || say "'vtbuild remove' has no --channel"
if [[ -x "$prefix/bin/vtrender" ]]; then offers glsl vtrender base.vts --path ''; fi
