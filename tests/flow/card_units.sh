#!/bin/bash
# The units of a card: no word of theirs is unknown to systemd, each is exposed by less than 2.
#   card_units.sh SYSTEMD_ANALYZE
set -euo pipefail
analyze=$1
card=$(cd "$(dirname "$0")/../.." && pwd)/device/card/root
units=("$card"/usr/lib/systemd/system/*.service)
[ -e "${units[0]}" ] || { echo "card_units: no units in $card" >&2; exit 1; }
complaints=$("$analyze" verify --man=no --recursive-errors=no "${units[@]}" 2>&1 | grep -F "$card" | grep -v 'is not executable' || true)
[ -z "$complaints" ] || { printf '%s\n' "$complaints" >&2; exit 1; }
for unit in "${units[@]}"; do
  "$analyze" security --no-pager --offline=true --threshold=19 "$unit" | tail -n 1
done
