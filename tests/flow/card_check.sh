#!/bin/sh
# Mistakes of a card have status 78 on a full disk too, a report that alone cannot be written has 1; so has a secret.
# Names are printed harmlessly, a card that is not there is told, and a wrong option says where help is.
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

cat >"$room/radio.toml" <<END
[network]
kind = 'wifi'
ssid = 'home'
password = 'not for everybody'
country = 'DE'
END
secret="$room/out/wpa_supplicant.conf"
"$card" "$room/radio.toml" -o "$room/out" || exit 1
[ "$(stat -c %a "$secret")" = 600 ] || { ls -l "$secret"; exit 1; }
rm "$secret" && mkdir "$secret"
if "$card" "$room/radio.toml" -o "$room/out" 2>"$room/said"; then echo 'a secret that was not written is no fault'; exit 1; fi
grep -q "ldp-card: cannot write $secret" "$room/said" || { cat "$room/said"; exit 1; }

# Names write no control sequences onto the terminal.
odd="$room/odd$(printf '\033').toml"
cp "$room/wrong.toml" "$odd"
"$card" "$odd" 2>"$room/said"
grep -q 'odd\\x1b.toml:1: ' "$room/said" || { cat -v "$room/said"; exit 1; }
! grep -q "$(printf '\033')" "$room/said" || { cat -v "$room/said"; exit 1; }

"$card" "$room/nothing.toml" 2>"$room/said" && grep -q "^ldp-card: there is no $room/nothing.toml: the defaults hold$" "$room/said" || { cat "$room/said"; exit 1; }

if "$card" "" 2>"$room/said"; then echo 'an empty name is no fault'; exit 1; fi
grep -q '^ldp-card: the name of the file is empty' "$room/said" || { cat "$room/said"; exit 1; }

for option in --output --report; do
  "$card" "$room/nothing.toml" $option "" 2>"$room/said"
  status=$?
  [ $status = 2 ] && grep -q "^ldp-card: $option: the name is empty: see" "$room/said" || { echo "status $status"; cat "$room/said"; exit 1; }
done
: >"$room/file"
if "$card" "$room/nothing.toml" -o "$room/file/in" 2>"$room/said"; then echo 'a folder in a file is no fault'; exit 1; fi
grep -q "^ldp-card: cannot make the folder $room/file/in: Not a directory$" "$room/said" || { cat "$room/said"; exit 1; }

"$card" --hel 2>"$room/said"
status=$?
[ $status = 2 ] && grep -q '^ldp-card: .*: see ldp-card --help$' "$room/said" || { echo "status $status"; cat "$room/said"; exit 1; }
