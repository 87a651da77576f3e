#!/usr/bin/env python3
"""What becomes of a capture, a service, a build, a file, an export and a gallery when one system call fails under them.

    tests/flow/fault_matrix.py [--short] BUILD [PART ...]      parts: capture service build read export gallery

Every row is one run under faults.c: which call of which kind fails how. The columns are what must hold:
    said   what failed is told in a line, and by the exit status whether the machine is at fault (or nothing had to be
           told: the work was done all the same)
    kept   nothing that was stored before, or was reported stored, is lost or changed
    next   the next sweep, build or export works, in the same process where that goes on
    clean  no descriptor more than before, no process, no temporary file, no half output
A row whose call is not made that often says so and counts nothing. --short: every fault of every call once, each at
another of its moments. Exit status 1 if any column of any row fails.
"""
import hashlib
import os
import pty
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

QUICK = ["--layers", "1", "--iterations", "1", "--labels", "2"]
PATIENCE_S = 120
TOLD = {"ENOSPC": "No space left", "EIO": "Input/output error", "EROFS": "Read-only", "EMFILE": "Too many open files",
        "ENOMEM": "emory", "EAGAIN": "temporarily unavailable", "EINTR": "Interrupted", "EACCES": "denied"}
STUB = """#!/bin/bash
capture=$2 file=$4
[[ " $* " != *' --follow '* ]] || while [ "$line" != end ]; do read -r line || exit 130; done
{ ls "$capture"; echo ended; } > "$file" || exit 2
"""


def tree(folder):
    """Path -> digest of everything below a folder."""
    found = {}
    for root, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(root, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    return found


def leftovers(folder):
    """Temporary files and half outputs."""
    empty = [entry.name for entry in os.scandir(folder) if entry.name.startswith("sweep_") and entry.is_dir()
             and not os.listdir(entry.path)]
    return empty + [path for path in tree(folder)
                    if path.endswith(".tmp") or ".building/" in path or ".partial" in path]


class Row:
    def __init__(self, part, fault):
        self.part, self.fault = part, fault
        self.hit, self.outcome, self.columns, self.why = True, "", {}, []

    def hold(self, column, holds, why=""):
        self.columns[column] = self.columns.get(column, True) and bool(holds)
        if not holds:
            self.why.append(f"{column}: {why}")

    def ok(self):
        return all(self.columns.values())


class Matrix:
    def __init__(self, build):
        self.bin = os.path.abspath(os.path.join(build, "bin"))
        self.faults = os.path.abspath(os.path.join(build, "tests/flow/libfaults.so"))
        self.room = tempfile.mkdtemp(prefix="ldp_matrix_")
        self.rows = []

    def path(self, *names):
        return os.path.join(self.room, *names)

    def environment(self, program, rule):
        env = dict(os.environ)
        if rule.startswith("TZ="):
            env["TZ"] = rule[3:]
        elif rule:
            env.update(LD_PRELOAD=self.faults, LDP_FAULTS=rule, LDP_FAULTS_IN=program,
                       LDP_FAULTS_LOG=self.path("hits"))
        return env

    def ldp(self, words, rule="", program="ldp"):
        if os.path.exists(self.path("hits")):
            os.remove(self.path("hits"))
        return subprocess.run([os.path.join(self.bin, program)] + words, env=self.environment(program, rule),
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S)

    def was_hit(self, rule):
        if rule.startswith("TZ=") or rule.startswith("clock"):
            return True
        with open(self.path("hits")) as file:
            return any(not line.startswith("polls") for line in file)

    # --- what is made once, in peace

    def prepare(self):
        made = self.ldp(["capture", "--camera", "scene:courtyard?fps=1000&hold=no&width=160&height=120", "--button",
                         "script:" + self.script("press wait 600000 release"), "-o", self.path("frames")],
                        program="ldp-device")
        if made.returncode != 0:
            sys.exit("cannot make frames: " + made.stderr)
        os.remove(self.path("frames", "capture.json"))
        self.originals = set(tree(self.path("frames")).values())
        os.mkdir(self.path("few_frames"))
        for name in sorted(os.listdir(self.path("frames")))[:6]:
            shutil.copy(self.path("frames", name), self.path("few_frames", name))
        built = self.ldp(["build", self.path("few_frames"), "-o", self.path("good.ldp")] + QUICK)
        if built.returncode != 0:
            sys.exit("cannot build: " + built.stderr)
        with open(self.path("stub"), "w") as file:
            file.write(STUB)
        os.chmod(self.path("stub"), 0o755)

    def script(self, words):
        with open(self.path("script"), "w") as file:
            file.write(words + "\n")
        return self.path("script")

    def camera(self):
        return "folder:" + self.path("frames") + "?fps=100&hold=no"

    # --- a run of ldp, before and after which its folder is compared

    def said(self, row, rule, status, text):
        lines = [line for line in text.splitlines() if line.strip()]
        action = rule.split()[3] if len(rule.split()) > 3 else ""
        if status != 0:
            row.hold("said", len(lines) == 1 and lines[0].startswith("ldp"), f"status {status}, said {lines}")
            of_machine = action in TOLD and row.part != "capture"  # a sweep is taken again by hand, not by a scheduler
            wanted = (1, 2) if action == "EACCES" else (75,) if of_machine else (1, 2, 75)
            row.hold("said", status in wanted and "internal error" not in text, f"status {status}: {text}")
            if action in TOLD:
                row.hold("said", TOLD[action] in text, f"does not name {action}: {text}")
        else:
            row.hold("said", True)

    def once(self, part, rule, words, output, wanted, program="ldp"):
        """Runs under the rule, with what is there already at `output`; then in peace. `wanted`: its bytes, or None."""
        row = Row(part, rule)
        self.rows.append(row)
        work = self.path("store")
        shutil.rmtree(work, ignore_errors=True)
        os.mkdir(work)
        if wanted is not None:
            shutil.copy(wanted, os.path.join(work, output))
        before = tree(work)
        run = self.ldp(words, rule, program)
        row.hit = self.was_hit(rule)
        row.outcome = f"status {run.returncode}"
        self.said(row, rule, run.returncode, run.stderr)
        after = tree(work)
        row.hold("kept", all(after.get(path) == digest for path, digest in before.items()), "an earlier output changed")
        row.hold("clean", not leftovers(work) and (run.returncode == 0 or set(after) == set(before)),
                 f"left {sorted(set(after) - set(before))}")
        again = self.ldp(words, "", program)
        row.hold("next", again.returncode == 0, again.stderr)
        if wanted is not None:
            with open(os.path.join(work, output), "rb") as one, open(wanted, "rb") as other:
                row.hold("next", one.read() == other.read(), "other bytes than in peace")

    def run_build(self, rule):
        self.once("build", rule, ["build", self.path("few_frames"), "-o", self.path("store", "good.ldp"), "--threads", "2"] +
                  QUICK, "good.ldp", self.path("good.ldp"))

    def run_read(self, rule):
        self.once("read", rule, ["info", self.path("good.ldp")], "", None)

    def run_export(self, rule):
        wanted = self.path("wanted.html")
        if not os.path.exists(wanted):
            self.ldp(["export", self.path("good.ldp"), "-o", wanted])
        self.once("export", rule, ["export", self.path("good.ldp"), "-o", self.path("store", "wanted.html")],
                  "wanted.html", wanted)

    # --- one sweep of ldp capture

    def run_capture(self, rule):
        row = Row("capture", rule)
        self.rows.append(row)
        work = self.path("store")
        shutil.rmtree(work, ignore_errors=True)
        os.mkdir(work)
        words = ["capture", "--camera", self.camera(), "--button", "script:" + self.path("script"), "--status",
                 "console:", "-o"]
        self.script("press wait 600000 release")
        run = self.ldp(words + [os.path.join(work, "one")], rule, "ldp-device")
        row.hit = self.was_hit(rule)
        stored = max([int(n) for n in re.findall(r"stored: (\d+) frames", run.stderr)], default=0)
        frames = [path for path in tree(work) if path.endswith(".jpg")]
        row.outcome = f"status {run.returncode}, {len(frames)} frames"
        last = run.stderr.strip().splitlines()[-1:] or [""]
        self.said(row, rule, run.returncode, last[0] if run.returncode else "")
        row.hold("kept", len(frames) >= stored, f"{stored} reported, {len(frames)} there")
        row.hold("kept", set(tree(work)[f] for f in frames) <= self.originals, "a frame is not the camera's")
        row.hold("clean", not leftovers(work), f"left {leftovers(work)}")
        again = self.ldp(words + [os.path.join(work, "two")], "", "ldp-device")
        row.hold("next", again.returncode == 0, again.stderr)
        action = rule.split()[3] if len(rule.split()) > 3 else ""
        in_peace = [path for path in tree(work) if path.startswith("two/") and path.endswith(".jpg")]
        if len(frames) < len(in_peace) and action in TOLD:
            row.hold("said", TOLD[action] in run.stderr, f"{len(frames)} frames, does not name {action}: {run.stderr}")

    # --- the service: a sweep under the rule, then one more

    def run_service(self, rule):
        row = Row("service", rule)
        self.rows.append(row)
        work = self.path("store")
        shutil.rmtree(work, ignore_errors=True)
        os.makedirs(os.path.join(work, "sweep_000001"))
        for name in os.listdir(self.path("frames")):
            shutil.copy(self.path("frames", name), os.path.join(work, "sweep_000001", name))
        shutil.copy(self.path("good.ldp"), os.path.join(work, "sweep_000001.ldp"))
        before = tree(work)
        service = Service(self, rule)
        alive = service.ready()
        descriptors = service.resting_descriptors() if alive else 0
        ended = service.sweep() if alive else "did not start"
        second = service.sweep() if service.alive() else ""
        if second.startswith("failed") and service.alive():  # the call came late: it was the second one that it hit
            ended, second = second, service.sweep()
        if service.alive():
            service.settle(descriptors)
            row.hold("clean", service.descriptors() == descriptors,
                     f"{service.descriptors()} descriptors instead of {descriptors}")
        status = service.stop()
        row.hit = self.was_hit(rule)
        text = service.said
        row.outcome = ended.split(":")[0][:24] + (f", status {status}" if status else "")
        action = rule.split()[3] if len(rule.split()) > 3 else ""
        if ended.startswith(("failed", "did not start", "ended")) and action in TOLD:
            row.hold("said", TOLD[action] in text, f"does not name {action}: {text}")
        else:
            row.hold("said", True)
        if not second.startswith("done"):  # the process did not go on: the next start does
            peace = Service(self, "")
            peace.ready()
            second = peace.sweep()
            peace.stop()
            row.hold("next", status == 1, f"ended with {status} after: {text}")
        row.hold("next", second.startswith("done"), f"'{second}' after: {text}")
        after = tree(work)
        row.hold("kept", all(after.get(path) == digest for path, digest in before.items()), "an earlier sweep changed")
        frames = [path for path in after if path.endswith(".jpg")]
        row.hold("kept", set(after[f] for f in frames) <= self.originals, "a frame is not the camera's")
        for folder, stored in service.reported():
            there = sum(1 for path in frames if path.startswith(folder + "/"))
            row.hold("kept", there >= stored, f"{folder}: {stored} reported, {there} there")
        row.hold("clean", not leftovers(work) and not service.children_left(), f"left {leftovers(work)}")

    # --- the gallery: every kind of answer and a removal under the rule, and once more

    def run_gallery(self, rule):
        row = Row("gallery", rule)
        self.rows.append(row)
        work = self.path("store")
        shutil.rmtree(work, ignore_errors=True)
        os.makedirs(os.path.join(work, "sweep_000001"))
        for name in ("capture.json", "frame_000.jpg", "frame_001.jpg"):
            with open(os.path.join(work, "sweep_000001", name), "w") as file:
                file.write(name)
        for name in ("room.ldp", "sweep_000001.ldp"):
            shutil.copy(self.path("good.ldp"), os.path.join(work, name))
        gallery = Gallery(self, rule)
        statuses = gallery.ask_all() if gallery.port else []
        at_rest = gallery.descriptors() if gallery.port else 0
        whole = os.path.exists(os.path.join(work, "sweep_000001.ldp"))
        removed = gallery.ask("/panoramas/sweep_000001.ldp", "DELETE")[0] if gallery.port else 0
        left = tree(work)
        lost = removed != 204 and "sweep_000001.ldp" not in left
        row.hold("kept", whole and not lost and left.get("room.ldp") == tree(self.room)["good.ldp"], f"{removed}: {left}")
        row.hold("said", all(status in (0, 200, 500, 503) for status in statuses + [removed or 500] if status != 204),
                 f"answers {statuses}, {removed}")
        again, gone = [], 0
        if gallery.port and gallery.alive():
            again = gallery.ask_all()
            gone = gallery.ask("/panoramas/sweep_000001.ldp", "DELETE")[0]
            row.hold("clean", gallery.descriptors() <= at_rest, f"{gallery.descriptors()} descriptors after {at_rest}")
        status = gallery.stop()
        row.hit = self.was_hit(rule)
        if not gallery.port:  # it did not start: in a line, and the next one does
            lines = gallery.said.splitlines()
            row.hold("said", status == 75 and len(lines) == 1 and lines[0].startswith("ldp"), f"status {status}: {lines}")
            peace = Gallery(self, "")
            again, gone = peace.ask_all(), peace.ask("/panoramas/sweep_000001.ldp", "DELETE")[0]
            peace.stop()
        row.outcome = f"answers {sorted(set(statuses + [removed]))}"
        row.hold("next", again and set(again) == {200} and gone in (204, 404), f"{again}, {gone}: {gallery.said}")
        row.hold("next", not os.path.exists(os.path.join(work, "sweep_000001")), "the sweep would be built again")
        row.hold("clean", status == (130 if gallery.port else 75), f"ended with {status}: {gallery.said}")

    # --- all of it

    def tell(self, row):
        if not row.hit:
            print(f"{row.part:8} {row.fault:44} the call is not made so often", flush=True)
            return
        marks = " ".join(f"{'ok' if row.columns.get(c, True) else 'FAIL':4}" for c in ("said", "kept", "next", "clean"))
        print(f"{row.part:8} {row.fault:44} {row.outcome:34} {marks}", flush=True)
        for why in row.why:
            print("         " + why.replace("\n", " | ")[:600])

    def run(self, parts, rules_of):
        print(f"{'part':8} {'fault':44} {'outcome':34} said kept next clean")
        for part in parts:
            for rule in rules_of(part):
                getattr(self, "run_" + part)(rule)
                self.tell(self.rows[-1])
        counted = [row for row in self.rows if row.hit]
        failed = [row for row in counted if not row.ok()]
        print(f"{len(counted)} faults, {len(failed)} rows fail")
        return 1 if failed else 0


class Service:
    """ldpd with a terminal as its button."""

    def __init__(self, matrix, rule):
        self.matrix = matrix
        self.log = matrix.path("said")
        with open(matrix.path("ldpd.toml"), "w") as file:
            file.write(f"[build]\nprogram = '{matrix.path('stub')}'\n[sweep]\nmin_frames = 3\n")
        for file in (self.log, matrix.path("hits")):
            if os.path.exists(file):
                os.remove(file)
        self.master, slave = pty.openpty()
        words = [os.path.join(matrix.bin, "ldpd"), "--config", matrix.path("ldpd.toml"), "--camera", matrix.camera(),
                 "--button", "keyboard:", "--status", "console:", "-o", matrix.path("store")]
        with open(self.log, "w") as log:
            self.process = subprocess.Popen(words, env=matrix.environment("ldpd", rule), stdin=slave, stderr=log,
                                            stdout=subprocess.DEVNULL)
        os.close(slave)

    def text(self):
        with open(self.log) as file:
            return file.read()

    def alive(self):
        return self.process.poll() is None

    def wait_for(self, pattern, begin):
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            found = re.search(pattern, self.text()[begin:], re.M)
            if found or not self.alive():
                return found
            time.sleep(0.01)
        return None

    def ready(self):
        return self.wait_for(r"^idle: ready", 0) is not None and self.alive()

    def sweep(self):
        begin = len(self.text())
        os.write(self.master, b" ")
        self.wait_for(r"^(capturing|failed)", begin)
        found = self.wait_for(r"^(done|failed): .*", begin)
        return found.group(0) if found else "ended"

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def resting_descriptors(self):
        """The fewest of some looks: now and then it has its folder open."""
        counts = []
        for _ in range(8):
            counts.append(self.descriptors())
            time.sleep(0.005)
        return min(counts)

    def settle(self, wanted):
        for _ in range(100):
            if self.descriptors() == wanted:
                return
            time.sleep(0.02)

    def reported(self):
        """Name and the most frames reported stored, by sweep; of those that came as far as a name."""
        for part in re.split(r"^capturing: capturing", self.said, flags=re.M)[1:]:
            names = re.findall(r"sweep_\d{6}", part)
            counts = [int(n) for n in re.findall(r"stored: (\d+) frames", part)]
            if names and counts:
                yield names[0], max(counts)

    def stop(self):
        self.children = []
        try:
            with open(f"/proc/{self.process.pid}/task/{self.process.pid}/children") as file:
                self.children = [int(pid) for pid in file.read().split()]
        except OSError:
            pass
        if self.alive():
            self.process.send_signal(signal.SIGTERM)
        try:
            status = self.process.wait(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        os.close(self.master)
        self.said = self.text()
        return status

    def children_left(self):
        def runs(pid):
            try:
                with open(f"/proc/{pid}/stat") as file:
                    return file.read().split(") ")[1][0] != "Z"
            except OSError:
                return False
        return any(runs(pid) for pid in self.children)


class Gallery:
    """ldp serve on a free port."""

    TOKEN = "a token of this test"
    PATHS = ("/", "/panoramas.json", "/panoramas/room.ldp", "/thumbnails/room.ldp", "/panoramas/room.jpg",
             "/sweeps/sweep_000001/frame_000.jpg")

    def __init__(self, matrix, rule):
        for file in (matrix.path("hits"), matrix.path("said")):
            if os.path.exists(file):
                os.remove(file)
        with open(matrix.path("token"), "w") as file:
            file.write(self.TOKEN + "\n")
        self.log = matrix.path("said")
        with open(self.log, "w") as log:
            self.process = subprocess.Popen([os.path.join(matrix.bin, "ldp"), "serve", matrix.path("store"), "--listen",
                                             "127.0.0.1:0", "--token-file", matrix.path("token"), "--threads", "2"],
                                            env=matrix.environment("ldp", rule), stdout=subprocess.PIPE, stderr=log, text=True)
        line = self.process.stdout.readline()
        self.port = int(line.split("/")[2].rsplit(":", 1)[1]) if line else 0

    def alive(self):
        return self.process.poll() is None

    def ask(self, path, method="GET"):
        """Status, 0 for a connection that just ended, and the body."""
        request = f"{method} {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nAuthorization: Bearer {self.TOKEN}\r\n\r\n"
        answer = b""
        try:
            with socket.create_connection(("127.0.0.1", self.port), PATIENCE_S) as client:
                client.sendall(request.encode())
                while part := client.recv(65536):
                    answer += part
        except OSError:
            pass
        head, _, body = answer.partition(b"\r\n\r\n")
        return int(head.split()[1]) if head else 0, body

    def ask_all(self):
        """The frame is gone once its sweep is; nothing else is told to be."""
        answers = [(path, self.ask(path)[0]) for path in self.PATHS]
        return [status for path, status in answers if status != 404 or not path.startswith("/sweeps/")]

    def descriptors(self):
        """The fewest of some looks: connections end a moment later."""
        counts = []
        for _ in range(40):
            counts.append(len(os.listdir(f"/proc/{self.process.pid}/fd")))
            time.sleep(0.01)
        return min(counts)

    def stop(self):
        if self.alive():
            self.process.send_signal(signal.SIGINT)
        try:
            status = self.process.wait(timeout=30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            status = self.process.wait()
        self.process.stdout.close()
        with open(self.log) as file:
            self.said = file.read()
        return status


def rules(*templates):
    return [t for template in templates for t in template]


def each(call, match, numbers, actions):
    return [f"{call} {match} {n} {action}" for action in actions for n in numbers]


def once_each(part):
    """Of the rules that differ in their number alone one, with another number every time."""
    kinds = {}
    for rule in PLAN[part]:
        words = rule.split()
        kinds.setdefault(tuple(words[:2] + words[3:]), []).append(rule)
    return [rules[i % len(rules)] for i, rules in enumerate(kinds.values())]


CLOCKS = ["clock - 1+ shift 86400", "clock - 1+ shift -86400", "clock - 5 shift 86400", "TZ=Pacific/Kiritimati"]
WRITES = ["ENOSPC", "EIO", "EROFS", "EINTR", "short"]
READS = ["EIO", "EINTR", "short"]
PLAN = {
    "capture": rules(each("open", "/store/one", (1, 4, 8), ("EMFILE", "EIO", "EROFS", "EINTR", "ENOMEM")),
                     each("write", "/store/one", (1, 2, 6), WRITES), each("fsync", ".tmp", (1, 5), ("EIO", "ENOSPC", "EINTR")),
                     each("fsync", "/one$", (1, 2, 5), ("EIO", "EINVAL")), each("rename", "/one", (1, 2, 7), ("EIO", "ENOSPC", "EROFS")),
                     each("mkdir", "/one", (1,), ("ENOSPC", "EROFS")), each("thread", "-", (1, 2), ("EAGAIN",)),
                     each("read", "/frames/", (1, 9), READS), each("unlink", "/one", (1,), ("EIO",)),
                     each("statvfs", "/store", (1,), ("EIO",)), each("malloc", "40000", (1, 8), ("ENOMEM",)), CLOCKS),
    "service": rules(each("open", "/store", (1, 2, 3, 5, 8, 12), ("EMFILE", "EIO", "EINTR")),
                     each("write", "/store", (1, 2, 3, 6, 30), WRITES),
                     each("fsync", "/store", (1, 2, 3, 4, 5, 9), ("EIO", "ENOSPC")),
                     each("rename", "/store", (1, 2, 3, 6, 31, 32), ("EIO", "ENOSPC", "EROFS")),
                     each("mkdir", "/store", (1, 2), ("ENOSPC", "EROFS")), each("fork", "-", (1, 2), ("EAGAIN", "ENOMEM")),
                     each("pipe", "-", (1, 2, 3, 4), ("EMFILE",)), each("thread", "-", (1,), ("EAGAIN",)),
                     each("read", "/frames/", (1, 9), READS), each("read", "/store/.last_sweep", (1, 2), READS),
                     each("unlink", "/store", (1, 2), ("EIO",)), each("statvfs", "/store", (1, 3), ("EIO",)),
                     each("malloc", "40000", (1, 10), ("ENOMEM",)), CLOCKS),
    "build": rules(each("open", "/few_frames/", (1, 9), ("EMFILE", "EIO", "EACCES", "EINTR")),
                   each("read", "/few_frames/", (1, 9), READS),
                   each("open", "/store/", (1, 2), ("EMFILE", "EROFS", "ENOMEM", "EINTR")), each("write", "/store/", (1,), WRITES),
                   each("fsync", ".tmp", (1,), ("EIO", "ENOSPC", "EINTR")), each("fsync", "/store$", (1,), ("EIO", "EINVAL")),
                   each("rename", "/store/", (1,), ("EIO", "ENOSPC", "EROFS")), each("thread", "-", (1, "2+", "3+"), ("EAGAIN",)),
                   each("malloc", "100000", (1, 5, 20, 60), ("ENOMEM",)), CLOCKS),
    "read": rules(each("open", "good.ldp", (1,), ("EMFILE", "EIO", "EACCES", "EINTR", "ENOMEM")),
                  each("mmap", "good.ldp", (1,), ("ENOMEM", "EIO")), each("malloc", "50000", (1,), ("ENOMEM",)), CLOCKS),
    "export": rules(each("open", "good.ldp", (1,), ("EMFILE", "EIO", "EINTR")), each("mmap", "good.ldp", (1,), ("ENOMEM",)),
                    each("open", "/store/", (1, 2), ("EMFILE", "EROFS", "ENOMEM", "EINTR")), each("write", "/store/", (1,), WRITES),
                    each("fsync", ".tmp", (1,), ("EIO", "ENOSPC", "EINTR")), each("fsync", "/store$", (1,), ("EIO", "EINVAL")),
                    each("rename", "/store/", (1,), ("EIO", "ENOSPC", "EROFS")), each("thread", "-", (1, "2+"), ("EAGAIN",)),
                    each("malloc", "100000", (1, 3), ("ENOMEM",)), CLOCKS),
    "gallery": rules(each("open", "room.ldp", (1, 2, 3), ("EMFILE", "EIO", "ENOMEM")),
                     each("open", "/proc/self/fd/", (1, 2), ("EMFILE", "ENOMEM")), each("mmap", "room.ldp", (1, 2), ("ENOMEM",)),
                     each("thread", "-", (2, "3+", "4+", "9"), ("EAGAIN",)), each("accept", "-", (1, 4), ("EMFILE", "ENOMEM")),
                     each("epoll", "-", (1, 3, 5), ("ENOMEM", "ENOSPC")), each("unlink", "frame_00", (1, 2), ("EIO", "EROFS")),
                     each("unlink", "capture.json", (1,), ("EIO",)), each("unlink", "sweep_000001$", (1,), ("EIO",)),
                     each("unlink", "sweep_000001.ldp", (1,), ("EIO",)), each("fsync", "/store", (1, 2, 3), ("EIO", "EINVAL")),
                     each("malloc", "40000", (1, 5), ("ENOMEM",)), CLOCKS),
}


def main():
    words = [word for word in sys.argv[1:] if word != "--short"]
    if not words:
        sys.exit(__doc__)
    matrix = Matrix(words[0])
    try:
        matrix.prepare()
        sys.exit(matrix.run(words[1:] or PLAN, once_each if "--short" in sys.argv else PLAN.get))
    finally:
        shutil.rmtree(matrix.room, ignore_errors=True)


if __name__ == "__main__":
    main()
