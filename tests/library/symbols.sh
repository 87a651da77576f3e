#!/bin/bash
# Holds a libldp to its list of symbols: none gone, none more, each under its version.
#   symbols.sh LIBRARY LIST
set -euo pipefail
wanted=$(sed -n 's/^ \([^ ]*\) .*/\1/p' "$2" | sort)
found=$(nm -D --defined-only --with-symbol-versions "$1" | awk '{ sub("@@", "@", $3); print $2 == "A" ? $3 "@" $3 : $3 }' | sort)
[ "$wanted" = "$found" ] || { diff <(echo "$wanted") <(echo "$found") | sed -n 's/^</gone: /p; s/^>/not in the list: /p'; exit 1; }
soname=$(readelf -d "$1" | sed -n 's/.*(SONAME).*\[\(.*\)\]/\1/p')
[ "$soname" = "$(awk 'NR == 1 { print $1 }' "$2")" ] || { echo "it calls itself $soname"; exit 1; }
