# What the tests inside the virtual machine share: a button of gpio-sim, the service, and checks that name what is wrong.
set -u
out=/tmp/out
said=/tmp/said
mkdir -p /tmp

step() { echo "[$SECONDS s] $*"; }

fail() {
  echo "FAILED: $*"
  echo "--- the service said:"
  tail -n 30 "$said" 2>/dev/null
  dmesg | tail -n 5
  exit 1
}

make_button() {
  local chip=/sys/kernel/config/gpio-sim/box
  mkdir -p "$chip/bank0/line0" "$chip/bank0/line1"
  echo 4 >"$chip/bank0/num_lines"
  echo capture-button >"$chip/bank0/line0/name"
  echo capture-led >"$chip/bank0/line1/name"
  echo 1 >"$chip/live" || fail "gpio-sim does not go live"
  pull=$(echo /sys/devices/platform/gpio-sim.*/gpiochip*/sim_gpio0/pull)
  led=$(echo /sys/devices/platform/gpio-sim.*/gpiochip*/sim_gpio1/value)
  echo pull-down >"$pull"
}

press() { echo pull-up >"$pull"; }
release() { echo pull-down >"$pull"; sleep 0.1; }  # shorter than the debouncing it were no release

# A contact that bounces to pull-up or pull-down: so many milliseconds between edges, without a process in between to be
# in time.
mkfifo /tmp/silence
bounce_to() {
  local other=pull-up gap level
  [ "$1" = pull-up ] && other=pull-down
  printf -v gap '0.%03d' "$2"
  for level in "$1" "$other" "$1" "$other" "$1" "$other" "$1"; do
    echo "$level" >"$pull"
    read -rt "$gap" <>/tmp/silence
  done
}

# The stand-in for the build waits for the end of a sweep it follows, and lists the frames into the panorama's file.
configure() {
  cat >/tmp/build <<'BUILD'
#!/bin/bash
capture=$2
case " $* " in *" --follow "*) until [ "${line:-}" = end ]; do read -r line || exit 130; done ;; esac
echo "0.5 poses" >&3
sleep "${BUILD_SECONDS:-0}"
while [ $# -gt 0 ]; do [ "$1" = -o ] && ls "$capture" >"$2"; shift; done
BUILD
  chmod +x /tmp/build
  {
    printf '[build]\nprogram = "%s"\noptions = [%s]\n[sweep]\n' "${BUILD_PROGRAM:-/tmp/build}" "${BUILD_OPTIONS:-}"
    printf '%s\n' "$@"
  } >/tmp/ldpd.toml
}

start_service() {
  : >"$said"
  ldpd --config /tmp/ldpd.toml --button 'gpiod:name=capture-button?debounce_ms=50' --output "$out" --status console: \
    --status led:name=capture-led "$@" 2>>"$said" &
  service=$!
  await "ready"
}

await() {
  local until=$((SECONDS + ${2:-40}))
  until grep -q "$1" "$said"; do
    [ "$SECONDS" -lt "$until" ] || fail "it never said '$1'"
    kill -0 "$service" 2>/dev/null || fail "the service died before it said '$1'"
    sleep 0.3
  done
}

forget() { : >"$said"; }

frames_in() { find "$1" -name 'frame_*.jpg' | wc -l; }

expect_capture() {
  local folder=$1 least=$2
  [ "$(frames_in "$folder")" -ge "$least" ] || fail "$folder holds $(frames_in "$folder") frames, expected $least or more"
  for frame in "$folder"/frame_*.jpg; do
    [ "$(tail -c 2 "$frame" | od -An -tx1 | tr -d ' ')" = ffd9 ] || fail "$frame is not whole"
  done
  grep -q '"frames"' "$folder/capture.json" || fail "$folder has no capture.json"
  [ -z "$(find "$out" -name '*.tmp')" ] || fail "temporary files are left"
}

# Every frame that was ever reported stored over LCM is there. /tmp/heard is what `ldp watch --json` printed.
listen() { ldp watch --json --status 'lcm:udpm://239.255.76.67:7667?ttl=0' >/tmp/heard & }
expect_reported() {
  /usr/bin/python3 -IS - "$out" <<'CHECK' || fail "frames that were reported stored are missing"
import glob, json, sys
stored = {}
for line in open("/tmp/heard"):
    if not line.endswith("}\n"):
        continue
    said = json.loads(line)
    if said["type"] == "status" and said["capture"]:
        stored[said["capture"]] = max(stored.get(said["capture"], 0), said["frames_stored"])
missing = {name: (n, len(glob.glob(f"{sys.argv[1]}/{name}/frame_*.jpg"))) for name, n in stored.items()}
print("reported stored, there:", missing)
sys.exit(0 if len(missing) > 3 and all(there >= said for said, there in missing.values()) else 1)
CHECK
}

expect_running() { kill -0 "$service" 2>/dev/null || fail "the service is not running any more"; }

stop_service() {
  kill -TERM "$service"
  wait "$service" || fail "the service ended with status $?"
}
