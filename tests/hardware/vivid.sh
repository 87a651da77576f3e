# The camera of vivid and a service that uses it, heard over LCM; `source` it after common.sh.
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
  sleep 0.1
}

start() { start_service --camera "$camera" --status 'lcm:udpm://239.255.76.67:7667?ttl=0'; }
expect_whole_frames() {
  local frame
  for frame in "$out"/sweep_*/frame_*.jpg; do
    [ -e "$frame" ] || continue
    [ "$(tail -c 2 "$frame" | od -An -tx1 | tr -d ' ')" = ffd9 ] || fail "$frame is not whole"
  done
}

make_button
configure 'min_frames = 3' 'lost_after_seconds = 6'
move_picture
listen
start
