#!/bin/bash
# Button (gpio-sim) and camera (vimc through libcamera): a sweep from press to release, a second one, a camera that goes.
. "$(dirname "$0")/common.sh"

# libcamera looks only at devices that udev has marked; there is no udev here.
for device in /sys/class/video4linux/*/dev /sys/bus/media/devices/*/dev; do
  echo "I:1" >"/run/udev/data/c$(cat "$device")"
done
make_button
configure 'min_frames = 3' 'lost_after_seconds = 10'
cam -l 2>/dev/null | grep -q "Sensor B" || fail "libcamera does not see vimc"
start_service --camera 'libcamera:platform/vimc.0 Sensor B?width=640&height=480'

for number in 1 2; do
  step "sweep $number from press to release"
  forget
  press
  await "sweep: 1 frames"
  sleep 2
  release
  grep -q "sweep_00000$number.ldp is ready" "$said" || await "are needed\|is ready"
  grep -q "libcamera\|Sensor B" "$out/sweep_00000$number/capture.json" || fail "no capture.json"
  [ "$(frames_in "$out/sweep_00000$number")" -ge 1 ] || fail "no frame was stored"
  expect_running
done
head -12 "$out/sweep_000001/capture.json"
stop_service
echo "all good"
