#!/bin/bash
# Projects of ten lines, by find_package and by pkg-config, against a tree that was installed and then moved.
#   projects.sh BUILD_FOLDER C_COMPILER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
for part in libldp0 libldp-dev; do
  cmake --install "$1" --prefix "$room/first" --component "$part" >/dev/null
done
mv "$room/first" "$room/installed"
project=$here/reader_project
file=$here/../golden/uniform_lossless.ldp expected='200x90, 3 layers'
cmake -S "$project" -B "$room/build" -DCMAKE_PREFIX_PATH="$room/installed" -DCMAKE_C_COMPILER="$2" >/dev/null
cmake --build "$room/build" >/dev/null
"$room/build/reader" "$file" | grep "$expected"

PKG_CONFIG_PATH=$(dirname "$(find "$room/installed" -name ldp.pc)")
export PKG_CONFIG_PATH
libraries=$(pkg-config --variable=libdir ldp)
read -ra flags <<<"$(pkg-config --cflags --libs ldp)"
"$2" -Wall -Wextra -Wpedantic -Werror -std=c11 "$project/reader.c" "${flags[@]}" -o "$room/reader"
LD_LIBRARY_PATH=$libraries "$room/reader" "$file" | grep "$expected"
! LD_LIBRARY_PATH=$libraries "$room/reader" "$project/reader.c" 2>"$room/said"
grep -q "open .*reader.c: " "$room/said"
