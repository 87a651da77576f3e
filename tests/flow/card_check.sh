#!/bin/sh
# Mistakes of a card have status 78 on a full disk too, a report that alone cannot be written has 1.
#   card_check.sh LDP_CARD
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
printf "effort = 'most'\n" >"$room/wrong.toml"
printf "effort = 'fast'\n" >"$room/right.toml"
expect() {  # status, file
  "$card" "$room/$2" --report /dev/full 2>"$room/said"
  status=$?
  grep -q 'ldp-card: cannot write /dev/full: No space left' "$room/said" || { cat "$room/said"; exit 1; }
  [ $status = "$1" ] || { echo "$2: status $status, expected $1"; exit 1; }
}
card=$1
expect 78 wrong.toml
expect 1 right.toml
