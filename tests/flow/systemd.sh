#!/bin/bash
# The service's unit under a real systemd, in namespaces of its own; skips (77) where those cannot be made.
#   tests/flow/systemd.sh UNIT LDPD
# The unit as it will be installed, but that the program is LDPD, its configuration lies in a scratch folder, and a restart
# waits 0.5 s instead of 5.
set -euo pipefail
unit=$(realpath "$1") ldpd=$(realpath "$2")

if [ "${3:-}" != inside ]; then
  systemd=/lib/systemd/systemd
  for needed in unshare "$systemd" systemctl; do
    command -v "$needed" >/dev/null || { echo "skipped: there is no $needed" && exit 77; }
  done
  room=$(mktemp -d "$PWD/systemd.XXXXXX")  # not below /tmp: the unit has one of its own
  chmod 755 "$room"
  trap 'rm -rf "$room"' EXIT
  unshare --mount --pid --fork --kill-child --cgroup --uts --ipc true 2>"$room/refused" ||
    { echo "skipped: $(cat "$room/refused")" && exit 77; }
  timeout 240 unshare --mount --pid --fork --kill-child --cgroup --uts --ipc "$0" "$unit" "$ldpd" inside "$room" || true
  cat "$room/log"
  [ -e "$room/booted" ] || { echo "skipped: systemd does not start in a container here" && exit 77; }
  exit "$(cat "$room/status" 2>/dev/null || echo 1)"
fi

# --- in the namespaces: what systemd needs, then systemd itself --------------------------------------------------------
room=$4
exec >"$room/log" 2>&1
mount -t proc proc /proc
for folder in /run /var/lib /sys/fs/cgroup; do mount -t tmpfs tmpfs "$folder"; done
mkdir /sys/fs/cgroup/systemd /sys/fs/cgroup/unified
mount -t cgroup -o none,name=systemd cgroup /sys/fs/cgroup/systemd
mount -t cgroup2 cgroup2 /sys/fs/cgroup/unified
for file in passwd group; do cp "/etc/$file" "$room/$file"; done
echo "ldpd:x:990:990::/var/lib/ldpd:/usr/sbin/nologin" >>"$room/passwd"
echo "ldpd:x:990:" >>"$room/group"
for file in passwd group; do mount --bind "$room/$file" "/etc/$file"; done

mkdir "$room/units"
sed -E "s|=[^ ]*/ldpd( \|\$)|=$ldpd --config $room/ldpd.toml\1|" "$unit" >"$room/units/ldpd.service"
mkdir "$room/units/ldpd.service.d"
printf '[Service]\nRestartSec=0.5\n[Unit]\nStartLimitIntervalSec=0\n' >"$room/units/ldpd.service.d/soon.conf"
for target in sysinit basic shutdown exit; do printf '[Unit]\nDefaultDependencies=no\n' >"$room/units/$target.target"; done
cat >"$room/units/exit.service" <<END
[Unit]
DefaultDependencies=no
[Service]
Type=oneshot
ExecStart=$(dirname "$(realpath "$0")")/systemd_check.sh $room
ExecStopPost=systemctl --force exit
StandardOutput=append:$room/log
StandardError=append:$room/log
END
exec env -i container=unshare PATH="$PATH" SYSTEMD_UNIT_PATH="$room/units" /lib/systemd/systemd --system \
  --unit=exit.service --log-target=console --log-level=warning --show-status=no
