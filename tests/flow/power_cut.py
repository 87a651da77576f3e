#!/usr/bin/env python3
"""A power cut at every moment of a sweep, of its build and of a file that is replaced.

    tests/flow/power_cut.py BUILD [--seed 1] [--frames 5]

ldpd and ldp run under faults.c, which records what they change in folders, what they flush, and between these lines
what they say. Then the power is cut after every step of the record. What a disk may hold by then: all that was flushed;
of names changed since their folder was flushed none, all, or some of them; files that were not flushed empty or cut
short. Of each such disk, once:
    kept   frames reported stored, and a panorama reported ready, are there, byte for byte
    whole  what has a name for good is whole
    next   the next start needs no hand: it says ready, builds what can be built, leaves no temporary file
One line a step, with the number of disks that were looked at. Exit status 1 if any column fails.
"""
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

QUICK = ["--layers", "1", "--iterations", "1", "--labels", "2", "--threads", "2"]
MIN_FRAMES = 3
PATIENCE_S = 120
STUB = """#!/bin/bash
capture=$2 file=$4
[[ " $* " != *' --follow '* ]] || while [ "$line" != end ]; do read -r line || exit 130; done
(ls "$capture"/*.jpg | wc -l; echo ended) > "$file" || exit 2
"""


def content(path):
    with open(path, "rb") as file:
        return file.read()


class Disk:
    """What of the steps so far is on the disk for sure, and what only may be."""

    def __init__(self, tree):
        self.lasting = dict(tree)  # path -> bytes, of folders None
        self.names = []            # (step, folders to flush for it): changes of names that may be lost
        self.flushed = {}          # path of a file by now -> what was flushed of it

    def take(self, step):
        kind, path, more = step
        if kind == "sync" and more is None:  # a folder
            kept = [change for change in self.names if os.path.dirname(change[1]) != path
                    and (change[0] != "rename" or os.path.dirname(change[2]) != path)]
            for change in self.names:
                if change not in kept:
                    apply(self.lasting, change, True)
            self.names = kept
        elif kind == "sync":
            self.flushed[path] = more
            if path in self.lasting:
                self.lasting[path] = more
            self.names = [(k, p, m, more if k == "open" and p == path else c) for k, p, m, c in self.names]
        elif kind == "rename":
            self.names.append((kind, path, more, self.flushed.get(path)))
            if path in self.flushed:
                self.flushed[more] = self.flushed.pop(path)
        else:
            self.names.append((kind, path, more, None))

    def possible(self, rng):
        """Disks after a power cut now: trees, each once."""
        count = len(self.names)
        choices = [[], list(range(count))] + [[i for i in range(count) if i != left] for left in range(count)]
        choices += [[i for i in range(count) if rng.random() < 0.5] for _ in range(3)] if count > 2 else []
        seen = []
        for chosen in choices:
            for torn in (b"", b"\xff\xd8 cut short"):
                tree = dict(self.lasting)
                for i in chosen:
                    apply(tree, self.names[i], True, torn)
                if tree not in seen:
                    seen.append(tree)
        return seen


def apply(tree, change, is_done, torn=b""):
    kind, path, more, flushed = change
    if kind == "open":
        tree.setdefault(path, flushed if flushed is not None else torn)
    elif kind == "mkdir":
        tree[path] = None
    elif kind == "unlink":
        tree.pop(path, None)
    elif kind == "rename" and is_done:
        tree.pop(path, None)
        tree[more] = flushed if flushed is not None else torn


class PowerCut:
    def __init__(self, options):
        self.options = options
        self.bin = os.path.abspath(os.path.join(options.build, "bin"))
        self.faults = os.path.abspath(os.path.join(options.build, "tests/flow/libfaults.so"))
        self.room = os.path.realpath(tempfile.mkdtemp(prefix="ldp_power_"))
        self.random = random.Random(options.seed)
        self.failures = 0

    def path(self, *names):
        return os.path.join(self.room, *names)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def run(self, program, words, record=None):
        """What it said, and with a folder to record into, what it did."""
        env = dict(os.environ)
        if record:
            os.mkdir(record)
            env.update(LD_PRELOAD=self.faults, LDP_FAULTS_IN=program, LDP_FAULTS_RECORD=record)
        with open(self.path("said"), "w+", opener=lambda p, f: os.open(p, f | os.O_APPEND | os.O_TRUNC)) as said:
            status = subprocess.run([os.path.join(self.bin, program)] + words, env=env, stdin=subprocess.DEVNULL,
                                    stdout=subprocess.DEVNULL, stderr=said, timeout=PATIENCE_S).returncode
        text = content(self.path("said")).decode()
        if status != 0:
            sys.exit(f"power_cut: {program} ended with {status}: {text}")
        return text

    def make_frames(self):
        self.write("script", "press wait 600000 release\n")
        self.run("ldp-device", ["capture", "--camera", "scene:courtyard?fps=1000&hold=no&width=160&height=120",
                                "--button", "script:" + self.path("script"), "-o", self.path("whole")])
        os.mkdir(self.path("frames"))
        for name in sorted(os.listdir(self.path("whole")))[1:self.options.frames + 1]:  # after capture.json
            shutil.copy(self.path("whole", name), self.path("frames", name))
        os.chmod(self.write("stub", STUB), 0o755)
        self.write("ldpd.toml", f"[build]\nprogram = '{self.path('stub')}'\n[sweep]\nmin_frames = {MIN_FRAMES}\n")

    def service(self, button):
        return ["--config", self.path("ldpd.toml"), "--camera", "folder:" + self.path("frames") + "?fps=100&hold=no",
                "--button", "script:" + self.write("script", button), "--status", "console:", "-o", self.path("store")]

    # --- the record

    def steps(self, text, record):
        """Deeds in the store as (kind, path, more), and lines that were said as ('said', line, '')."""
        store = self.path("store")
        for line in text.splitlines():
            if not line.startswith("@"):
                yield "said", line, ""
                continue
            kind, path, more = line[1:].split("\t")
            if path.startswith(store) or more.startswith(store):
                if kind == "sync":
                    more = None if more == "-" else content(os.path.join(record, more))
                yield kind, path, more

    def put(self, tree):
        shutil.rmtree(self.path("store"), ignore_errors=True)
        os.mkdir(self.path("store"))
        for path in sorted(tree):
            if tree[path] is None:
                os.makedirs(path, exist_ok=True)
            elif os.path.isdir(os.path.dirname(path)):  # what lies in a folder that was lost is lost
                with open(path, "wb") as file:
                    file.write(tree[path])

    def tree(self):
        found = {}
        for root, folders, names in os.walk(self.path("store")):
            found.update({os.path.join(root, name): None for name in folders})
            found.update({os.path.join(root, name): content(os.path.join(root, name)) for name in names})
        return found

    def replay(self, title, before, steps, check):
        disk, said, seen, disks = Disk(before), [], [], 0
        for number, step in enumerate(steps, 1):
            if step[0] == "said":
                said.append(step[1])
            else:
                disk.take(step)
            wrong, looked = set(), 0
            for tree in disk.possible(self.random):
                if (tree, len(said)) in seen:
                    continue
                seen.append((tree, len(said)))
                self.put(tree)
                looked += 1
                wrong |= set(check(said))
            disks += looked
            if looked:
                what = step[1] if step[0] == "said" else f"{step[0]} {os.path.relpath(step[1], self.path('store'))}"
                print(f"{title:8} {number:4} {what[:72]:72} {looked:3} {' | '.join(sorted(wrong)) or 'ok'}", flush=True)
            self.failures += len(wrong)
        print(f"{title}: power cut at {number} steps, {disks} disks")

    # --- what must hold

    def next_start(self):
        process = subprocess.Popen([os.path.join(self.bin, "ldpd")] + self.service("wait 1"), stderr=subprocess.PIPE,
                                   stdin=subprocess.DEVNULL)
        os.set_blocking(process.stderr.fileno(), False)
        stored = [name for name in self.frames_there()]
        wanted = len(stored) >= MIN_FRAMES and not os.path.exists(self.path("store", "sweep_000001.ldp"))
        text, until = "", time.monotonic() + PATIENCE_S
        while time.monotonic() < until and process.poll() is None:
            text += (process.stderr.read() or b"").decode()
            if "ready" in text and (not wanted or re.search(r"^(done|failed):", text, re.M)):
                break
            time.sleep(0.005)
        process.send_signal(signal.SIGTERM)
        process.wait(timeout=30)
        if "idle: ready" not in text:
            yield "next: " + text[-200:]
        if wanted and not os.path.exists(self.path("store", "sweep_000001.ldp")):
            yield "next: not built: " + text[-200:]
        left = [path for path in self.tree() if path.endswith(".tmp")]
        if left:
            yield f"next: left {left}"

    def frames_there(self):
        folder = self.path("store", "sweep_000001")
        return [name for name in os.listdir(folder) if name.endswith(".jpg")] if os.path.isdir(folder) else []

    def check_sweep(self, said):
        reported = max([int(n) for line in said for n in re.findall(r"stored: (\d+) frames", line)], default=0)
        ready = any(line.startswith("done: ") for line in said)
        folder = self.path("store", "sweep_000001")
        for name in [f"frame_{i:03}.jpg" for i in range(reported)]:
            path = os.path.join(folder, name)
            if not os.path.exists(path) or content(path) != self.after[path]:
                yield f"kept: {name} was reported stored"
        panorama = folder + ".ldp"
        if ready and not os.path.exists(panorama):
            yield "kept: the panorama was reported ready"
        for path in [os.path.join(folder, name) for name in self.frames_there()] + [panorama]:
            if os.path.exists(path) and content(path) != self.after[path]:
                yield f"whole: {os.path.basename(path)}"
        yield from self.next_start()

    def cut_sweep(self):
        os.mkdir(self.path("store"))
        before = self.tree()
        text = self.run("ldpd", self.service("wait 100 press wait 600000 release") + ["--once"], self.path("sweep"))
        self.after = self.tree()
        self.replay("sweep", before, list(self.steps(text, self.path("sweep"))), self.check_sweep)

    def check_file(self, said):
        path = self.path("store", "a.ldp")
        if not os.path.exists(path) or content(path) not in (self.old, self.new):
            yield "whole: neither the old file nor the new one"
        elif any(line.startswith("@@done") for line in said) and content(path) != self.new:
            yield "kept: the new file"

    def cut_file(self):
        shutil.rmtree(self.path("store"))
        os.mkdir(self.path("store"))
        words = ["build", self.path("frames"), "-o", self.path("store", "a.ldp")] + QUICK
        self.run("ldp", words + ["--quality", "50"])
        self.old, before = content(self.path("store", "a.ldp")), self.tree()
        text = self.run("ldp", words, self.path("file"))
        self.new = content(self.path("store", "a.ldp"))
        steps = [step for step in self.steps(text, self.path("file")) if step[0] != "said"]
        self.replay("build", before, steps + [("said", "@@done", "")], self.check_file)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--frames", type=int, default=5)
    cut = PowerCut(parser.parse_args())
    try:
        cut.make_frames()
        cut.cut_sweep()
        cut.cut_file()
        sys.exit(1 if cut.failures else 0)
    finally:
        shutil.rmtree(cut.room, ignore_errors=True)


if __name__ == "__main__":
    main()
