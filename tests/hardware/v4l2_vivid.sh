#!/bin/bash
# Button (gpio-sim) and camera (vivid through V4L2): sweeps, bounces, a press while building, a button held for ever.
. "$(dirname "$0")/common.sh"
. "$(dirname "$0")/vivid.sh"

step "a sweep from press to release"
press
await "capturing: turn"
[ "$(cat "$led")" = 1 ] || fail "the LED is off while capturing"
await "$some_frames"
release
await "sweep_000001.ldp is ready"
expect_capture "$out/sweep_000001" 3
grep -q "\"pixel_format\": \"yuyv\"" "$out/sweep_000001/capture.json" || fail "not YUYV"
seen=  # a second on, a second off: good
for _ in $(seq 30); do seen+=$(cat "$led") && sleep 0.1; done
[[ $seen == *1111*0000* || $seen == *0000*1111* ]] || fail "the LED shows $seen when all is done"

number=1
for bounce_ms in 1 5 10 20; do
  step "a button that bounces for $bounce_ms ms makes one sweep"
  forget
  number=$((number + 1))
  sweep 0 "$bounce_ms"
  await "sweep_00000$number.ldp is ready"
  expect_capture "$out/sweep_00000$number" 3
  [ "$(grep -c 'capturing: turn' "$said")" = 1 ] || fail "more than one sweep"
done

step "a double press is a sweep that is too short, and says so"
forget
number=$((number + 1))
press; sleep 0.1; release; sleep 0.1
await "are needed"
press; sleep 0.1; release; sleep 0.3
number=$((number + 1))
expect_running

step "a press while building is refused, and nothing is lost"
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

step "a button held for ever: the sweep ends by itself, and letting go later begins nothing"
configure 'min_frames = 3' 'lost_after_seconds = 6' 'max_seconds = 5'
start
press
await "the sweep is complete"
await "ldp is ready"
sleep 3.5
release
sleep 0.5
[ "$(grep -c 'capturing: turn' "$said")" = 1 ] || fail "more than one sweep"
stop_service
expect_reported
expect_whole_frames
echo "all good"
