#!/bin/bash
# Button (gpio-sim) and camera (vivid through V4L2): sweeps, bounces, a busy device, errors injected, a camera unplugged.
. "$(dirname "$0")/common.sh"

camera=v4l2:/dev/video0?width=320\&height=180\&fps=15\&format=yuyv
some_frames='sweep: \([3-9]\|[1-9][0-9]\) frames'
control() { v4l2-ctl -d /dev/video0 -c "$1" || fail "vivid refuses $1"; }
move_picture() { control osd_text_mode=2 && control horizontal_movement=1; }

sweep() {  # SECONDS [BOUNCE_MS]
  bounce_to pull-up "${2:-0}"
  await "capturing: turn"
  await "$some_frames"
  sleep "$1"
  bounce_to pull-down "${2:-0}"
}

make_button
configure 'min_frames = 3' 'lost_after_seconds = 2'
move_picture
listen
start() { start_service --camera "$camera" --status 'lcm:udpm://239.255.76.67:7667?ttl=0'; }
start

echo "a sweep from press to release"
press
await "capturing: turn"
[ "$(cat "$led")" = 1 ] || fail "the LED is off while capturing"
await "$some_frames"
release
await "sweep_000001.ldp is ready"
expect_capture "$out/sweep_000001" 3
grep -q "\"pixel_format\": \"yuyv\"" "$out/sweep_000001/capture.json" || fail "not YUYV"
[ "$(cat "$led")" = 0 ] || fail "the LED is on when all is done"

number=1
for bounce_ms in 1 5 10 20; do
  echo "a button that bounces for $bounce_ms ms makes one sweep"
  forget
  number=$((number + 1))
  sweep 0 "$bounce_ms"
  await "sweep_00000$number.ldp is ready"
  expect_capture "$out/sweep_00000$number" 3
  [ "$(grep -c 'capturing: turn' "$said")" = 1 ] || fail "more than one sweep"
done

echo "a double press is a sweep that is too short, and says so"
forget
number=$((number + 1))
press; sleep 0.1; release; sleep 0.1
await "are needed"
press; sleep 0.1; release; sleep 0.3
number=$((number + 1))
expect_running

echo "a press while building is refused, and nothing is lost"
stop_service
export BUILD_SECONDS=3
start
sweep 0
await "building: building"
captures=$(find "$out" -maxdepth 1 -type d -name 'sweep_*' | wc -l)
press; await "please wait"; release
await "ldp is ready"
[ "$(find "$out" -maxdepth 1 -type d -name 'sweep_*' | wc -l)" = "$captures" ] || fail "the press began a sweep"
stop_service
unset BUILD_SECONDS

echo "a button held for ever: the sweep ends by itself, and letting go later begins nothing"
configure 'min_frames = 3' 'lost_after_seconds = 2' 'max_seconds = 5'
start
press
await "the sweep is complete"
await "ldp is ready"
sleep 3.5
release
sleep 0.5
[ "$(grep -c 'capturing: turn' "$said")" = 1 ] || fail "more than one sweep"
stop_service
configure 'min_frames = 3' 'lost_after_seconds = 2'
start

echo "streaming cannot start: a failure, and the next sweep works"
forget
control inject_vidioc_streamon_error=1
press; await "cannot start streaming"; release
grep -q "^failed" "$said" || fail "not failed"
expect_running
number=$((number + 1))
forget
sweep 0
await "ldp is ready"

echo "the stream breaks in mid-sweep: what was taken is built"
forget
press; await "$some_frames"
control inject_fatal_streaming_error=1
await "storing"
release
await "ldp is ready"
expect_running

echo "the camera is unplugged in mid-sweep: what was taken is built, and after replugging the next sweep works"
forget
press; await "$some_frames"
control disconnect=1
await "storing"
release
await "ldp is ready"
expect_running
modprobe -r -d "$(cat /run/job/module-root)" vivid || fail "vivid is still held by the service"
forget
press; await "failed: "; release
grep -q "/dev/video0" "$said" || fail "it does not say which camera is missing"
modprobe -d "$(cat /run/job/module-root)" vivid n_devs=1
sleep 1
move_picture
forget
sweep 0
await "ldp is ready"

echo "the driver goes away in mid-sweep: it cannot be unloaded while the camera streams, only unbound"
forget
press; await "$some_frames"
modprobe -r -d "$(cat /run/job/module-root)" vivid 2>/dev/null && fail "vivid let itself be unloaded in mid-sweep"
echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind
await "storing"
release
await "ldp is ready"
expect_running
modprobe -r -d "$(cat /run/job/module-root)" vivid || fail "vivid is still held by the service"
modprobe -d "$(cat /run/job/module-root)" vivid n_devs=1
sleep 1
move_picture
forget
sweep 0
await "ldp is ready"
expect_reported

for folder in "$out"/sweep_*/; do
  for frame in "$folder"frame_*.jpg; do
    [ -e "$frame" ] || continue
    [ "$(tail -c 2 "$frame" | od -An -tx1 | tr -d ' ')" = ffd9 ] || fail "$frame is not whole"
  done
done

echo "the button goes away: the service stays; it comes back: the next sweep works"
forget
echo 0 >/sys/kernel/config/gpio-sim/box/live
await "the button was lost"
expect_running
make_button
await "the button is there"
sweep 0
await "ldp is ready"
stop_service
echo "all good"
