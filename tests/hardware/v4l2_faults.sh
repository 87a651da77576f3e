#!/bin/bash
# A camera (vivid through V4L2) that fails in every way its driver knows, and a button (gpio-sim) that goes away.
. "$(dirname "$0")/common.sh"
. "$(dirname "$0")/vivid.sh"

step "streaming cannot start: a failure, and the next sweep works"
forget
control inject_vidioc_streamon_error=1
press; await "cannot start streaming"; release
grep -q "^failed" "$said" || fail "not failed"
expect_running
forget
sweep 0
await "ldp is ready"

step "the stream breaks in mid-sweep: what was taken is built"
forget
press; await "$some_frames"
control inject_fatal_streaming_error=1
await "storing"
release
await "ldp is ready"
expect_running

step "the camera is unplugged in mid-sweep: what was taken is built, and after replugging the next sweep works"
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

step "the driver goes away in mid-sweep: it cannot be unloaded while the camera streams, only unbound"
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

expect_whole_frames

step "the button goes away: the service stays; it comes back: the next sweep works"
forget
echo 0 >/sys/kernel/config/gpio-sim/box/live
await "the button was lost"
await "led:name=capture-led: the GPIO line was lost"
expect_running
make_button
await "the button is there"
sweep 0
await "ldp is ready"
stop_service
echo "all good"
