#!/usr/bin/env bash
# debian_packages.sh BUILD WORK: cpack makes two packages that name what they need; unpacked, the programs
# run.
set -euo pipefail
build="$1" work="$2"
rm -rf "$work"
mkdir -p "$work"
say() { echo "$*"; exit 1; }
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work" >"$work/log" || { cat "$work/log"; exit 1; }

packages=("$work"/*.deb)
[[ ${#packages[@]} == 2 ]] || say "there are not two packages: ${packages[*]}"
tools="$(echo "$work"/vt-tools_*.deb)" development="$(echo "$work"/libvt-dev_*.deb)"

# Fields and files that are to be there.
depends_on() {
  local depends
  depends="$(dpkg-deb -f "$1" Depends)"
  grep -qx "$2" <<<"$(tr ',' '\n' <<<"$depends" | sed 's/^ *//; s/ .*//')" || say "$1 does not depend on $2, but: $depends"
}
depends_on "$tools" libopenimageio2.4
depends_on "$tools" libzstd1
for package in libzstd1 libxxhash0 libexpected-dev libzstd-dev libxxhash-dev; do depends_on "$development" "$package"; done
dpkg-deb -c "$tools" | awk '{print $6}' >"$work/tools.files"
dpkg-deb -c "$development" | awk '{print $6}' >"$work/development.files"
holds() { grep -qx "$2" "$work/$1.files" || say "$1 holds no $2"; }
holds tools ./usr/bin/vtbuild
holds tools ./usr/bin/vtinspect
holds tools ./usr/lib/vt/vt_pictures.so
holds tools ./usr/share/man/man1/vtbuild.1.gz
holds tools ./usr/share/bash-completion/completions/vtbuild
holds tools ./usr/share/vt/schemas/dataset.schema.json
holds development './usr/include/vt/store/store_reader.h'
holds development './usr/include/vt/runtime/virtual_texture.h'
for file in libvt_store.a libvt_store.so 'libvt_store.so.[0-9.]*' libvt_runtime.a libvt_runtime.so cmake/vt/vtConfig.cmake pkgconfig/vt-store.pc; do
  holds development "./usr/lib/$file"
done
if comm -12 <(grep -v '/$' "$work/tools.files" | sort) <(grep -v '/$' "$work/development.files" | sort) | grep .; then say "these files are in both"; fi
if grep -E 'vtbench|_test' "$work/tools.files"; then say "these are not for users"; fi
grep -q ldconfig <<<"$(dpkg-deb -I "$development" postinst)" || say "installing the libraries does not tell ldconfig"

# The programs run from where the package puts them, with every library found.
for package in "${packages[@]}"; do dpkg-deb -x "$package" "$work/root"; done
for file in "$work"/root/usr/bin/* "$work"/root/usr/lib/libvt_*.so "$work"/root/usr/lib/vt/*.so; do
  if ldd "$file" | grep 'not found'; then say "of $file"; fi
  if grep -q debug_info <<<"$(readelf -S "$file")"; then say "$file is not stripped"; fi
done
"$work/root/usr/bin/vtbuild" --version
"$work/root/usr/bin/vtinspect" --version
