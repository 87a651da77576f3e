#!/usr/bin/env python3
"""Many captures on a real Slurm, one node of which dies half way: all are built in the end, none twice at the same time.

    tests/fleet/slurm_fleet.py LDP FLEET [--captures 40]

slurmctld, two slurmd and munge run on loopback from a scratch folder, each node in a process namespace of its own, so
that it dies with all that runs on it. Two captures are no photographs: they are refused, once. One build finds a full
disk the first time: its task is requeued. Skips (77) where Slurm or namespaces are absent, or not as root.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 400
CONFIGURATION = """
ClusterName=fleet
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={room}/munge/socket
CryptoType=crypto/munge
SlurmctldPort={ports[0]}
StateSaveLocation={room}/state
SlurmctldPidFile={room}/slurmctld.pid
SlurmdPidFile={room}/%n.pid
SlurmdSpoolDir={room}/%n
SlurmctldLogFile={room}/slurmctld.log
SlurmdLogFile={room}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_min_interval=200000
SlurmdTimeout=8
KillWait=2
MinJobAge=86400
MpiDefault=none
MailProg=/bin/true
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs={processors} RealMemory=2000
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs={processors} RealMemory=2000
PartitionName=all Nodes=ALL Default=YES State=UP MaxTime=60
"""
# Says when a build began and ended; the first time that the last capture is built, its disk is full. While "hold" is
# there, what node n2 begins lasts until the node dies.
WITNESS = """#!/bin/bash
[ "$1" = build ] && [[ " $* " != *' --estimate '* ]] || exec "$REAL" "$@"
name=$(basename "$2")
echo "begin $name $$ $(date +%s.%N) $SLURMD_NODENAME" >>"$WITNESSED"
if [ "$SLURMD_NODENAME" = n2 ] && [ -e "$WITNESSED.hold" ]; then
  touch "$WITNESSED.held"
  exec sleep 600
fi
status=0
if [ "$name" = "$FULL" ] && [ ! -e "$WITNESSED.full" ]; then
  touch "$WITNESSED.full"
  echo "ldp build: cannot write $name: No space left on device" >&2
  status=75
else
  sleep .5
  "$REAL" "$@" || status=$?
fi
echo "end $name $$ $(date +%s.%N) $status" >>"$WITNESSED"
exit $status
"""


def skip(why):
    print("skipped:", why)
    sys.exit(77)


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Cluster:
    def __init__(self, room, processors=2):
        self.room, self.nodes, self.own = room, {}, []
        for name in ("munge", "state", "n1", "n2"):
            (room / name).mkdir(mode=0o755)
        host = socket.gethostname().split(".")[0]
        (room / "slurm.conf").write_text(CONFIGURATION.format(room=room, host=host, ports=free_ports(3), processors=processors))
        os.environ["SLURM_CONF"] = str(room / "slurm.conf")

    def start(self):
        munge = self.room / "munge"
        (munge / "key").write_bytes(os.urandom(1024))
        (munge / "key").chmod(0o400)
        self.own.append(subprocess.Popen(
            ["munged", "--foreground", f"--key-file={munge}/key", f"--socket={munge}/socket", f"--pid-file={munge}/pid",
             f"--log-file={munge}/log", f"--seed-file={munge}/seed"], stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        self.wait_for(lambda: (munge / "socket").exists(), "munge")
        self.own.append(self.daemon("slurmctld", "-D"))
        for name in ("n1", "n2"):
            self.nodes[name] = self.daemon("unshare", "--pid", "--fork", "--kill-child", "--mount-proc", "slurmd", "-D", "-N", name)
        self.wait_for(lambda: self.says("sinfo", "-h", "-o", "%T %D").split() == ["idle", "2"], "both nodes")

    def daemon(self, *words):
        with open(self.room / "daemons.log", "a") as log:
            return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def says(self, *words):
        return subprocess.run(words, capture_output=True, text=True).stdout

    def wait_for(self, holds, what, seconds=60):
        end = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > end:
                sys.exit(f"slurm_fleet: waited in vain for {what}\n" + (self.room / "daemons.log").read_text()[-3000:])
            time.sleep(0.2)

    def kill_node(self, name):
        self.nodes[name].kill()  # unshare's child, the first process of its namespace, goes with it, and all others with that
        self.nodes[name].wait()

    def hurry(self):
        """What Slurm requeues waits two minutes: not here."""
        for line in self.says("squeue", "-h", "-r", "-t", "PD", "-o", "%i %r").splitlines():
            if line.endswith(" BeginTime"):
                self.says("scontrol", "update", "JobId=" + line.split()[0], "StartTime=now")

    def stop(self):
        for process in list(self.nodes.values()) + self.own[::-1]:
            process.kill()
            process.wait()


def make_captures(ldp, room, count):
    made = room / "made"
    subprocess.run([ldp, "scene", "courtyard", "-o", made, "--size", "160x120", "--frames", "8", "--arc", "60", "--no-novel"],
                   check=True, stdout=subprocess.DEVNULL)
    captures = []
    for index in range(count):
        captures.append(room / f"sweep_{index:03d}")
        (captures[-1]).mkdir()
        for photo in sorted((made / "frames").iterdir()):
            os.link(photo, captures[-1] / photo.name)
    for index in (7, 23):  # no photographs in two of them
        shutil.rmtree(captures[index])
        captures[index].mkdir()
    (room / "list").write_text("".join(f"{capture}\n" for capture in captures))
    return captures


def check_intervals(witnessed, dead_at):
    """No build of a capture begins before another of it has ended, or died with its node."""
    runs, ended = {}, {}
    for line in witnessed.read_text().splitlines():
        word, name, pid, when, last = line.split(" ")
        if word == "begin":
            runs.setdefault(name, []).append([float(when), None, last, pid])
        else:
            ended[name, pid, float(when)] = last
    for (name, pid, when), _ in ended.items():
        for run in runs[name]:
            if run[3] == pid and run[1] is None:
                run[1] = when
                break
    killed = 0
    for name, list_of_runs in runs.items():
        for before, after in zip(list_of_runs, list_of_runs[1:]):
            end = before[1]
            if end is None:
                assert before[2] == "n2", f"{name} ended nowhere on {before[2]}"
                end, killed = dead_at, killed + 1
            assert after[0] >= end, f"{name} was built twice at the same time"
        assert list_of_runs[-1][1] is not None, f"{name} never ended"
    return runs, killed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("ldp")
    parser.add_argument("fleet")
    parser.add_argument("--captures", type=int, default=40)
    told = parser.parse_args()
    for program in ("slurmctld", "slurmd", "munged", "sbatch", "unshare"):
        shutil.which(program) or skip(f"there is no {program}: toolchain/setup fleet")
    if os.geteuid() != 0 or subprocess.run(["unshare", "--pid", "--fork", "--mount-proc", "true"], capture_output=True).returncode:
        skip("process namespaces cannot be made here")
    room = pathlib.Path(tempfile.mkdtemp(prefix="slurm_fleet."))
    room.chmod(0o755)
    cluster = Cluster(room)
    try:
        run(cluster, room, os.path.realpath(told.ldp), os.path.realpath(told.fleet), told.captures)
    finally:
        cluster.stop()
        if os.environ.get("KEEP"):
            print("kept:", room)
        else:
            shutil.rmtree(room, ignore_errors=True)


def run(cluster, room, ldp, fleet, count):
    captures = make_captures(ldp, room, count)
    witnessed, out = room / "witnessed", room / "out"
    (room / "witness").write_text(WITNESS)
    (room / "witness").chmod(0o755)
    os.environ.update(LDP=str(room / "witness"), REAL=ldp, WITNESSED=str(witnessed), FULL=captures[-1].name)
    cluster.start()
    options = ["--", "--layers", "1", "--iterations", "1", "--labels", "4"]
    began = time.monotonic()
    job = subprocess.run([fleet + "/on_slurm", room / "list", out, *options], check=True, capture_output=True, text=True).stdout.strip()
    assert re.fullmatch(r"\d+", job), job
    done = lambda: len(list(out.glob("*.ldp")))
    cluster.wait_for(lambda: done() >= count // 3, "a third of the panoramas", PATIENCE_S)
    hold = room / "witnessed.hold"
    hold.touch()
    cluster.wait_for((room / "witnessed.held").exists, "a build on the node that is to die", PATIENCE_S)
    cluster.kill_node("n2")
    dead_at = time.time()
    hold.unlink()

    def over():
        cluster.hurry()
        return not cluster.says("squeue", "-h", "-j", job).strip()
    cluster.wait_for(over, "the end of the job", PATIENCE_S)
    runs, killed = check_intervals(witnessed, dead_at)
    assert killed > 0, "no build died with its node"
    assert done() == count - 2, f"{done()} panoramas"
    for capture in captures:
        report = json.loads((out / (capture.name + ".json")).read_text())
        refused = not any(capture.iterdir())
        assert ("failure" in report) == refused, capture.name
        assert not refused or (len(runs[capture.name]) == 1 and report["failure"]["status"] == 2), report
    assert len(runs[captures[-1].name]) >= 2, "a full disk was not tried again"
    told = json.loads(subprocess.run([ldp, "summary", out, "--json"], check=True, capture_output=True, text=True).stdout)
    assert (told["builds"], told["failed"]) == (count, 2), told
    again = subprocess.run([fleet + "/on_slurm", room / "list", out, *options], capture_output=True, text=True)
    assert again.returncode == 2 and "none of the captures looked at can be built" in again.stderr, again.stderr
    print(f"{count} captures, {sum(map(len, runs.values()))} builds, {killed} died with their node and were done again, "
          f"2 refused once, {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
