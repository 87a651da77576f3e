#!/bin/bash
# A card's image of a small root, read back by other programs: its table, its three file systems, its settings by ldp-card,
# the same bytes again.
#   card_image.sh LDP_CARD
set -euo pipefail
ldp_card=$1
export PATH=$PATH:/usr/sbin:/sbin SOURCE_DATE_EPOCH=1700000000
source=$(cd "$(dirname "$0")/../.." && pwd)
for program in mksquashfs unsquashfs mkfs.fat fsck.fat mcopy mke2fs e2fsck sfdisk python3; do
  command -v "$program" >/dev/null || { echo "skipped: '$program' is missing (toolchain/setup test)"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "card_image: $*" >&2; exit 1; }

mkdir -p "$work"/root/{usr/bin,dev,proc,etc} "$work/boot/loader/entries"
cp -r "$source/device/card/root/." "$work/root/"
echo 'not the card' >"$work/root/proc/left-out"
cp "$source/device/card/boot/camera.toml" "$work/boot/"
head -c 3000000 /dev/zero | tr '\0' k >"$work/boot/vmlinuz"
echo 'title Camera' >"$work/boot/loader/entries/camera.conf"
assemble() { "$source/toolchain/card/assemble" --root "$work/root" --boot "$work/boot" -o "$1" >/dev/null; }
assemble "$work/card.img"

sfdisk --json "$work/card.img" >"$work/table.json"
python3 - "$work/table.json" "$(stat -c %s "$work/card.img")" <<'CHECK'
import json, sys
table = json.load(open(sys.argv[1]))["partitiontable"]
parts = table["partitions"]
assert table["label"] == "dos" and table["id"] == "0x6c647063", table
assert [p["type"] for p in parts] == ["c", "83", "83"] and parts[0]["bootable"], parts
assert all(p["start"] % 2048 == 0 for p in parts), parts
assert all(a["start"] + a["size"] == b["start"] for a, b in zip(parts, parts[1:])), parts
assert (parts[2]["start"] + parts[2]["size"]) * 512 == int(sys.argv[2]), "the data partition does not end the image"
open(sys.argv[1] + ".cut", "w").writelines(f"{p['start'] // 2048} {p['size'] // 2048}\n" for p in parts)
CHECK
number=0
while read -r start size; do
  number=$((number + 1))
  dd if="$work/card.img" of="$work/part$number" bs=1M skip="$start" count="$size" status=none
done <"$work/table.json.cut"

fsck.fat -n "$work/part1" >/dev/null || fail "the boot partition is damaged"
e2fsck -fn "$work/part3" >/dev/null 2>&1 || fail "the data partition is damaged"
[ "$(blkid -o value -s LABEL "$work/part3")" = ldp-data ] || fail "the data partition has another label"
unsquashfs -quiet -no-progress -d "$work/unpacked" "$work/part2" >/dev/null || fail "the root cannot be unpacked"
diff -r --exclude=dev --exclude=proc --exclude=sys --exclude=run --exclude=tmp "$work/root" "$work/unpacked" || fail "the root is not what was given"
for folder in dev proc sys run tmp; do
  [ -d "$work/unpacked/$folder" ] && [ -z "$(find "$work/unpacked/$folder" -mindepth 1)" ] || fail "$folder is missing or not empty"
done

mcopy -n -i "$work/part1" ::camera.toml ::vmlinuz "$work/"
cmp "$work/vmlinuz" "$work/boot/vmlinuz"
"$ldp_card" "$work/camera.toml" -o "$work/configuration" --report "$work/report"
grep -q 'without a mistake' "$work/report"
"$(dirname "$ldp_card")/ldpd" --check-config --config "$work/configuration/ldpd.toml" >/dev/null

touch "$work/root/etc/fstab" "$work/boot/camera.toml"  # when they were made is not what they are
assemble "$work/again.img"
cmp "$work/card.img" "$work/again.img" || fail "the same folders gave other bytes"

echo more >"$work/root/etc/more"
assemble "$work/other.img"
! cmp -s "$work/card.img" "$work/other.img" || fail "another root gave the same bytes"
mkdir "$work/boot/full" && head -c 200M /dev/zero >"$work/boot/full/too-much"
! assemble "$work/full.img" 2>"$work/why" || fail "a boot partition that does not hold its files was made"
grep -q 'do not hold' "$work/why" || fail "it was not said that the boot partition is full: $(cat "$work/why")"
[ ! -e "$work/full.img" ] || fail "half an image was left"
echo "a card's image holds what it was made of"
