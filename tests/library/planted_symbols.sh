#!/bin/bash
# Shows that symbols.sh tells a symbol that is gone, one that is new, and one under another version.
#   planted_symbols.sh LIBRARY LIST C_COMPILER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
mapfile -t names < <(sed -n 's/^ \(ldp_[^@]*\)@.*/\1/p' "$2")
planted() {  # words expected, version of the symbols, names
  local expected=$1 version=$2
  shift 2
  printf 'void %s(void) {}\n' "$@" >"$room/planted.c"
  printf 'void %s(void);\n' "$@" | cat - "$room/planted.c" >"$room/a.c"
  echo "$version { global: ldp_*; local: *; };" >"$room/map"
  "$compiler" -shared -fPIC -Wl,-soname,libldp.so.0 -Wl,--version-script="$room/map" "$room/a.c" -o "$room/libldp.so"
  if bash "$here/symbols.sh" "$room/libldp.so" "$list" >"$room/said"; then
    [ -z "$expected" ] || { echo "nothing was said of: $expected"; exit 1; }
  else
    [ -n "$expected" ] && grep -q "$expected" "$room/said" || { cat "$room/said"; exit 1; }
  fi
}
list=$2 compiler=$3
planted "" LDP_0 "${names[@]}"
planted "gone:  ${names[3]}@LDP_0" LDP_0 "${names[@]:0:3}" "${names[@]:4}"
planted "not in the list:  ldp_planted@LDP_0" LDP_0 "${names[@]}" ldp_planted
planted "not in the list:  ${names[0]}@LDP_1" LDP_1 "${names[@]}"
