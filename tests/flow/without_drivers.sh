#!/bin/sh
# ldpd built without drivers takes a sweep of the simulated camera, and names what it knows where another one is asked for.
#   without_drivers.sh LDPD
set -eu
room=$(mktemp -d)
trap 'rm -rf "$room"' EXIT
printf 'press wait 2000 release\n' >"$room/turn.script"
printf '[build]\nmemory_limit_mib = 0\n' >"$room/ldpd.toml"  # a sanitized program's shadow has none
"$1" --config "$room/ldpd.toml" --once --camera 'scene:room?fps=10&width=96&height=72&frames=16' --button "script:$room/turn.script" \
  --status console: -o "$room/captures" 2>"$room/said" || true  # so small that it may not be posed
[ "$(find "$room/captures" -name 'frame_*' | wc -l)" -ge 3 ] || { echo "too few frames were stored"; exit 1; }
status=0
"$1" --once --camera v4l2:/dev/video0 --button keyboard: -o "$room/none" 2>"$room/said" || status=$?
[ "$status" -eq 2 ] && grep -q 'no camera of that kind; known: folder:, scene:' "$room/said" || { cat "$room/said"; exit 1; }
