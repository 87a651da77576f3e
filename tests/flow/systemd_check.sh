#!/bin/bash
# Run by systemd.sh as a unit beside the service, in the folder ROOM that it made.
#   systemd_check.sh ROOM
room=$1
touch "$room/booted"
failed=0
value() { systemctl show ldpd.service --property "$1" --value; }
expect() { # what, is, should be
  if [ "$2" = "$3" ]; then echo "ok: $1: $2"; else echo "FAILED: $1: '$2' instead of '$3'" && failed=1; fi
}
wait_for() { for _ in $(seq 300); do eval "$1" && return 0; sleep 0.2; done; echo "FAILED: $1 did not come true" && failed=1; }
good_configuration() {
  cat >"$room/ldpd.toml" <<END
camera = 'scene:courtyard?width=160&height=120&fps=100&hold=no'
button = 'script:$room/script'
output = '/var/lib/ldpd'
[build]
options = ['--layers', '1', '--iterations', '1', '--labels', '4']
END
  echo "$1" >"$room/script"
}

# A mistake in the configuration: not once more.
echo 'camera = 7' >"$room/ldpd.toml"
systemctl start ldpd.service
sleep 3
expect "restarts on bad configuration" "$(value NRestarts)" 0
expect "state" "$(value ActiveState)" failed
systemctl reset-failed ldpd.service

# A button that is held where no sweep is: switched off, and not once more.
cat >"$room/ldpd.toml" <<END
camera = 'folder:/nowhere'
button = 'script:$room/script'
output = '/var/lib/ldpd'
switch_off_seconds = 4
END
echo 'press wait 300000 release' >"$room/script"
systemctl start ldpd.service
wait_for '[ "$(value ExecMainStatus)" = 10 ]'
sleep 3
expect "restarts after it was switched off" "$(value NRestarts)" 0
expect "state" "$(value ActiveState)" failed
systemctl reset-failed ldpd.service

# A sweep in the sandbox, then a kill, then a stop.
good_configuration 'press wait 300000 release'
systemctl start ldpd.service
expect "state once it is ready" "$(value ActiveState)" active
wait_for '[ -e /var/lib/ldpd/sweep_000001.ldp ]'
good_configuration 'wait 600000'
systemctl kill --signal=KILL ldpd.service
wait_for '[ "$(value NRestarts)" = 1 ] && [ "$(value ActiveState)" = active ]'
systemctl stop ldpd.service
expect "result of the stop" "$(value Result)" success
expect "files of other users in its folder" "$(find /var/lib/ldpd ! -user ldpd | wc -l)" 0
echo "$failed" >"$room/status"
