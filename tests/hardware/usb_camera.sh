#!/bin/bash
# A USB camera on the stock uvcvideo driver that shows the frames of a synthetic sweep: what is stored is byte by byte
# what the camera sent, and its panorama shows the views of one built from the same frames directly; pulled out in
# mid-sweep, what was taken is built.
#   usb_camera.sh FRAMES PANORAMA BUILD_OPTION ...      PANORAMA = built from FRAMES with these options
. "$(dirname "$0")/common.sh"
frames=$1
panorama=$2
shift 2

plug() {
  /usr/bin/python3 -IS "$(dirname "$0")/usb_camera.py" "$frames" 4 2>/tmp/camera.log &
  camera=$!
  local tries=0
  until [ -e /dev/video0 ]; do
    tries=$((tries + 1))
    [ "$tries" -lt 150 ] || fail "uvcvideo does not find the camera: $(cat /tmp/camera.log)"
    sleep 0.1
  done
}

# A sweep of so many frames: the camera shows the next picture when the one before is stored.
turn_through() {
  await "capturing: turn"
  for stored in $(seq 1 "$1"); do
    await "stored: $stored frames"
    kill -USR1 "$camera"
  done
}

# Every stored frame is one of the camera's, and they come in its order.
expect_camera_frames() {
  /usr/bin/python3 -IS - "$1" "$frames" <<'CHECK' || fail "$1 does not hold the camera's frames"
import glob, sys
stored, sent = ([open(name, "rb").read() for name in sorted(glob.glob(folder + "/frame_*.jpg"))] for folder in sys.argv[1:3])
order = [sent.index(frame) for frame in stored]
sys.exit(0 if order == sorted(set(order)) else str(order))
CHECK
}

# The views are those of the panorama built directly: nearly all pixels the same to a few grey levels.
expect_views() {
  ldp render "$1" --path sway --frames 3 -o /tmp/views || fail "$1 cannot be rendered"
  ldp render "$panorama" --path sway --frames 3 -o /tmp/direct || fail "$panorama cannot be rendered"
  /usr/bin/python3 - <<'CHECK' || fail "$1 shows other views than $panorama"
import glob, math, sys
import numpy, PIL.Image
good = 0
for name in sorted(glob.glob("/tmp/direct/*.png")):
    a, b = (numpy.asarray(PIL.Image.open(f).convert("RGBA"), float) for f in (name, name.replace("direct", "views")))
    psnr = 10 * math.log10(255**2 / max(((a - b) ** 2).mean(), 1e-6))
    print(f"{name}: {psnr:.1f} dB")
    good += psnr > 40 and a[..., :3].std() > 20
sys.exit(0 if good == 3 else 1)
CHECK
}

make_button
BUILD_PROGRAM=$(command -v ldp)
BUILD_OPTIONS=$(printf '"%s",' "$@")
every_picture=('min_frames = 3' 'lost_after_seconds = 8' 'overlap = 0.95' 'max_seconds = 300')
configure "${every_picture[@]}"
plug
start_service --camera v4l2:/dev/video0

step "the frames of a sweep arrive byte by byte"
count=$(frames_in "$frames")
press
turn_through "$count"
release
await "sweep_000001.ldp is ready" 400
expect_capture "$out/sweep_000001" "$count"
expect_camera_frames "$out/sweep_000001"
expect_views "$out/sweep_000001.ldp"
grep -q "Simulated USB camera" "$out/sweep_000001/capture.json" || fail "the camera's name is missing"
grep -q '"pixel_format": "mjpeg"' "$out/sweep_000001/capture.json" || fail "not MJPEG"

step "the plug is pulled in mid-sweep"
stop_service
unset BUILD_PROGRAM BUILD_OPTIONS
configure "${every_picture[@]}"
kill -9 "$camera"
while [ -e /dev/video0 ]; do sleep 0.1; done
plug
start_service --camera v4l2:/dev/video0
press
turn_through 4
kill -9 "$camera"
await "storing"
release
await "sweep_000002.ldp is ready"
expect_camera_frames "$out/sweep_000002"
expect_running

step "plugged in again"
while [ -e /dev/video0 ]; do sleep 0.1; done
plug
forget
press
turn_through 4
release
await "sweep_000003.ldp is ready"
expect_camera_frames "$out/sweep_000003"
stop_service
echo "all good"
