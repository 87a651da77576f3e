#!/bin/bash
# A newer package on a card's boot partition: taken with its checksum alone, kept at later starts, given up for the one
# before when the service does not come up; and started at every step of its being kept, as after a power cut.
#   card_update.sh
set -euo pipefail
script=$(cd "$(dirname "$0")/../.." && pwd)/device/card/root/usr/lib/ldp-camera/take-update
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "card_update: $*" >&2; exit 1; }

# The script with its folders here; what it would lay over the root is a line.
mkdir "$work/bin"
sed -e "s#/data/update#$work/data#; s#/run/camera#$work/run#g; s#/boot/firmware#$work/boot#g; s#dpkg-deb -x \"\(.*\)\" /;#{ [ ! -e $work/unpackable ] \&\& echo laid: \"\$(cat \"\1\")\"; };#" "$script" >"$work/take-update"
grep -q 'echo laid' "$work/take-update" || fail "take-update lays in another way than this test knows"
cat >"$work/bin/systemctl" <<SYSTEMCTL
#!/bin/sh
case "\$*" in *is-active*) [ -e $work/active ] ;; *daemon-reload) ;; *) echo "systemctl \$*" ;; esac
SYSTEMCTL
chmod +x "$work/bin/systemctl"
take() { PATH=$work/bin:$PATH sh "$work/take-update" "$@" 2>&1; }

fresh() { rm -rf "$work"/{boot,data,run} && mkdir "$work"/{boot,run} && touch "$work/active"; }
package() { echo "layered-depth-panorama_$1_arm64.deb"; }
offer() {
  echo "package $1" >"$work/boot/$(package "$1")"
  (cd "$work/boot" && sha256sum "$(package "$1")" >"$(package "$1").sha256")
}
expect() { grep -qF -- "$2" <<<"$1" || fail "expected '$2', it said: $1"; }
expect_not() { ! grep -qF -- "$2" <<<"$1" || fail "did not expect '$2', it said: $1"; }

fresh
said=$(take lay)
expect "$said" "those that the card was made with" && expect_not "$said" "laid"
offer 0.2.0 && rm "$work/boot/$(package 0.2.0).sha256"
said=$(take lay)
expect "$said" "its checksum, must lie beside it" && expect_not "$said" "laid"
offer 0.2.0 && echo damage >>"$work/boot/$(package 0.2.0)"
said=$(take lay)
expect "$said" "copy both again" && expect_not "$said" "laid"

offer 0.2.0
tr a-f A-F <"$work/boot/$(package 0.2.0).sha256" | sed 's/^\([^ ]*\).*/\1\r/' >"$work/sum" && cp "$work/sum" "$work/boot/$(package 0.2.0).sha256"
said=$(take lay && take judge)
expect "$said" "laid: package 0.2.0" && expect "$(cat "$work/run/reports/update-report.txt")" "0.2.0_arm64.deb is installed"
rm "$work"/boot/*
expect "$(take lay && take judge)" "laid: package 0.2.0"  # kept

offer 0.3.0
rm "$work/active"
said=$(take lay && take judge)
expect "$said" "laid: package 0.3.0" && expect "$said" "systemctl --no-block reboot"
touch "$work/active"
said=$(take lay && take judge)
expect "$said" "laid: package 0.2.0" && expect "$said" "it was given up" && expect_not "$said" "laid: package 0.3.0"

offer 0.3.1  # a mistake in camera.toml, for which nothing starts, says nothing of it; a ldp-card that fails does
rm "$work/active" && echo mistake >"$work/run/mistaken"
for _ in 1 2 3 4 5 6 7; do expect "$(take lay && take judge)" "laid: package 0.3.1"; done
echo failure >"$work/run/mistaken"
expect "$(take lay && take judge)" "systemctl --no-block reboot"
rm "$work/run/mistaken" && touch "$work/active"
expect "$(take lay && take judge)" "laid: package 0.2.0"

offer 0.4.0  # it takes the machine with it before anybody can judge
for _ in 1 2 3 4 5; do expect "$(take lay)" "laid: package 0.4.0"; done
expect "$(take lay && take judge)" "laid: package 0.2.0"

offer 0.5.0 && expect "$(take lay)" "laid: package 0.5.0"
touch "$work/boot/no-updates.old" "$work/boot/no-updates.txt.txt" && rm "$work/active"  # it is not judged by the image's own programs
said=$(take lay && take judge)
expect "$said" "while no-updates.txt is here" && expect_not "$said" "laid" && expect_not "$said" "systemctl"
rm "$work/boot/no-updates.txt.txt" && touch "$work/active"
expect "$(take lay && take judge)" "laid: package 0.5.0"

# Damage, and no room, in what is kept and in memory: nothing is laid half, nor again and again.
fresh
offer 0.2.0 && take lay >/dev/null && take judge >/dev/null
offer 0.3.0 && take lay >/dev/null && take judge >/dev/null
rm "$work"/boot/*
kept=$(cat "$work/data/current")
echo damage >>"$work/data/$kept.deb"
said=$(take lay)
expect "$said" "There is damage in, or no memory for, $(package 0.3.0)" && expect "$said" "systemctl --no-block reboot" && expect_not "$said" "laid: package 0.3.0"
expect "$(take lay && take judge)" "laid: package 0.2.0"
touch "$work/unpackable" && offer 0.4.0
said=$(take lay)
expect "$said" "no memory for, $(package 0.4.0)" && expect "$said" "reboot"
rm "$work/unpackable"
said=$(take lay && take judge)
expect "$said" "laid: package 0.2.0" && expect "$said" "it was given up"
offer 0.5.0
printf '#!/bin/sh\nhead -c 5 "$1" >"$2"; echo "cp: No space left on device" >&2; exit 1\n' >"$work/bin/cp" && chmod +x "$work/bin/cp"
said=$(take lay && take judge)
rm "$work/bin/cp"
expect "$said" "has no room to keep it" && expect "$said" "laid: package 0.2.0"
[ -z "$(find "$work/data" -name '*.new')" ] || fail "a half of a package was left"

# Ended at each of its steps: the next start goes on to the new package.
{
  echo 'step=0 last=$1 && set -- lay'
  for word in cp mv sync; do echo "$word() { step=\$((step + 1)) && [ \$step -ne \$last ] || exit 9; command $word \"\$@\"; }"; done
  cat "$work/take-update"
} >"$work/cut"
steps=0
while :; do
  fresh
  offer 0.2.0 && take lay >/dev/null && take judge >/dev/null
  offer 0.3.0
  steps=$((steps + 1))
  PATH=$work/bin:$PATH sh "$work/cut" "$steps" >"$work/said" 2>&1 && cut=no || cut=yes
  said=$(take lay && take judge)
  expect "$said" "laid: package 0.3.0"
  [ "$cut" = yes ] || break
done
[ "$steps" -gt 10 ] || fail "it was ended at $steps steps only"
echo "an update is taken, kept and given up as it should, and at $((steps - 1)) steps of a power cut"
