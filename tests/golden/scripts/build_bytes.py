#!/usr/bin/env python3
"""The same photos and cameras give the same file on every machine and with any number of threads.

    build_bytes.py [--write] [--poses] DIGESTS CAPTURES -- LDP...

LDP... is the program `ldp`, with an emulator before it for another processor. Builds every capture in the folder
CAPTURES with its cameras, with 1 and with 4 threads, and compares the size and checksum of every chunk of the files with
those in DIGESTS (JSON). --write puts the digests there instead: do so, on any machine, after a change that was meant to
change results (tests/golden/regenerate), and commit them with it.

With --poses the cameras are estimated, and DIGESTS holds poses: centres must agree to 1e-6 of the arc's radius, angles to
1e-6 radians; the differences are printed.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

OPTIONS = {"courtyard": [], "terrace": ["--rays", "central", "--block", "8"], "room": ["--layers", "2", "--quality", "101"]}
WORST = 1e-6


def run(program, arguments):
    done = subprocess.run(program + arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(program + arguments)}: exit status {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def chunks_of(program, file):
    """{"DPTH 0.0": "812 9f00b3aa"}: a chunk's type, layer and strip; its bytes and CRC-32C."""
    chunks = json.loads(run(program, ["info", file, "--json"]))["chunks"]
    return {f"{c['type']} {c['layer']}.{c['strip']}": f"{c['bytes']} {c['crc32c']:08x}" for c in chunks}


def built(program, capture, name, threads, room):
    file = os.path.join(room, f"{name}_{threads}.ldp")
    run(program, ["build", capture, "-o", file, "--cameras", os.path.join(capture, "transforms.json"),
                  "--threads", str(threads)] + OPTIONS.get(name, []))
    return chunks_of(program, file)


def differences(expected, found):
    return [f"{chunk}: expected {expected.get(chunk, 'none')}, found {found.get(chunk, 'none')}"
            for chunk in sorted(set(expected) | set(found)) if expected.get(chunk) != found.get(chunk)]


def poses_of(program, capture, name, room):
    file = os.path.join(room, f"{name}.json")
    run(program, ["poses", capture, "-o", file, "--fov", "58"])
    with open(file) as text:
        found = json.load(text)
    return {"fl_x": found["fl_x"], "frames": {f["file_path"]: f["transform_matrix"] for f in found["frames"]}}


def angle_between(a, b):
    """Of the rotations in two 4x4 matrices: |A - B| = 2 sqrt(2) sin(angle / 2)."""
    squared = sum((a[i][j] - b[i][j]) ** 2 for i in range(3) for j in range(3))
    return 2 * math.asin(min(1, math.sqrt(squared / 8)))


def pose_differences(expected, found):
    if sorted(expected["frames"]) != sorted(found["frames"]):
        return [f"other frames were posed: expected {sorted(expected['frames'])}, found {sorted(found['frames'])}"]
    radius = 0.65  # estimated poses have the default arm length
    shift = turn = 0
    for name, a in expected["frames"].items():
        b = found["frames"][name]
        shift = max(shift, math.dist([row[3] for row in a[:3]], [row[3] for row in b[:3]]) / radius)
        turn = max(turn, angle_between(a, b))
    focal = abs(found["fl_x"] / expected["fl_x"] - 1)
    print(f"  centres differ by {shift:.1e} of the radius, angles by {turn:.1e} rad, the focal length by {focal:.1e}")
    return [] if max(shift, turn) <= WORST else [f"more than {WORST:.0e}"]


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--poses", action="store_true")
    parser.add_argument("digests")
    parser.add_argument("captures")
    parser.add_argument("program", nargs="+")
    options = parser.parse_args()
    if options.write:
        golden = {}
    else:
        with open(options.digests) as text:
            golden = json.load(text)
    wrong = []
    with tempfile.TemporaryDirectory() as room:
        for name in sorted(os.listdir(options.captures)):
            capture = os.path.join(options.captures, name)
            if options.poses:
                print(f"{name}, poses")
                found = poses_of(options.program, capture, name, room)
                if options.write:
                    golden[name] = found
                else:
                    wrong += [f"{name}: {d}" for d in pose_differences(golden[name], found)]
                continue
            for threads in (1, 4):
                print(f"{name}, {threads} threads", flush=True)
                found = built(options.program, capture, name, threads, room)
                if options.write:
                    golden.setdefault(name, found)
                wrong += [f"{name}, {threads} threads: {d}" for d in differences(golden[name], found)]
    if options.write and not wrong:
        with open(options.digests, "w") as text:
            text.write(json.dumps(golden, indent=1, sort_keys=True) + "\n")
    print("\n".join(wrong) if wrong else "all as expected")
    sys.exit(1 if wrong else 0)


main()
