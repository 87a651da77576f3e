#!/usr/bin/env python3
"""Views as .exr, read by a reader written from the format's specification alone, against the .png and .pfm beside them.

  exr_check.py LDP GOLDEN_FOLDER      LDP: the program. Status 77 where it was built without OpenEXR
"""
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy
from PIL import Image

PROGRAM, GOLDEN = sys.argv[1], pathlib.Path(sys.argv[2])
BLOCKS = GOLDEN / "whole_strips.ldp"
SIZE = (161, 90)  # 90 rows: the last block of 16 is cut off
ROUNDING = 1e-3  # what half floats may round away, relative


def terminated(content, at):
    end = content.index(b"\0", at)
    return content[at:end].decode("ascii"), end + 1


def attributes(content):
    """{name: (type, bytes)} of a file of one part in rows, and where its table of rows begins."""
    assert struct.unpack_from("<ii", content) == (20000630, 2)
    found, at = {}, 8
    while content[at]:
        name, at = terminated(content, at)
        kind, at = terminated(content, at)
        (size,) = struct.unpack_from("<i", content, at)
        found[name] = kind, content[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def channels(content):
    """[(name, type of numpy)] in the order in which they are stored."""
    found, at = [], 0
    while content[at]:
        name, at = terminated(content, at)
        kind, linear, *reserved, x, y = struct.unpack_from("<iB3Bii", content, at)
        assert (linear, reserved, x, y) == (0, [0, 0, 0], 1, 1)
        found.append((name, {1: "<f2", 2: "<f4"}[kind]))
        at += 16
    assert at + 1 == len(content) and found == sorted(found)
    return found


def unpacked(block, size):
    """A block of rows: stored as it is where packing does not help; else deflated differences of its even bytes, then odd."""
    if len(block) == size:
        return block
    delta = numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(numpy.int64)
    assert len(delta) == size
    delta[1:] -= 128
    plain = (numpy.cumsum(delta) % 256).astype(numpy.uint8)
    out = numpy.empty(size, numpy.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = plain[:half], plain[half:]
    return out.tobytes()


def read_exr(file):
    """{channel: array}, and the attributes."""
    content = file.read_bytes()
    head, at = attributes(content)
    assert head["compression"] == ("compression", b"\3") and head["lineOrder"] == ("lineOrder", b"\0")
    left, top, right, bottom = struct.unpack("<4i", head["dataWindow"][1])
    assert (left, top) == (0, 0) and head["displayWindow"] == head["dataWindow"]
    width, height, stored = right + 1, bottom + 1, channels(head["channels"][1])
    bytes_per_row = sum(numpy.dtype(kind).itemsize for _, kind in stored) * width
    planes = {name: numpy.empty((height, width), kind) for name, kind in stored}
    tops = range(0, height, 16)
    end = at + 8 * len(tops)
    for top, place in zip(tops, struct.unpack_from(f"<{len(tops)}Q", content, at)):
        y, size = struct.unpack_from("<ii", content, place)
        assert (y, place) == (top, end)  # the blocks follow each other without gaps
        end = place + 8 + size
        rows = range(top, min(top + 16, height))
        block, offset = unpacked(content[place + 8:end], bytes_per_row * len(rows)), 0
        for row in rows:
            for name, kind in stored:
                planes[name][row] = numpy.frombuffer(block, kind, width, offset)
                offset += planes[name][row].nbytes
    assert end == len(content)
    return planes, head


def read_pfm(file):
    _, size, _, rows = file.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return numpy.frombuffer(rows, "<f4").reshape(height, width)[::-1]


def linear(srgb):
    s = srgb / 255
    return numpy.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)


def render(folder, *options):
    return subprocess.run([PROGRAM, "render", BLOCKS, "--path", "sway", "--frames", "2", "--size", "%dx%d" % SIZE,
                           "--fill", "none", "-o", folder, *options], capture_output=True, text=True)


def check_view(stem):
    exr, head = read_exr(stem.with_suffix(".exr"))
    rgba = numpy.asarray(Image.open(stem.with_suffix(".png"))).astype(float)
    depth = read_pfm(stem.with_suffix(".pfm"))
    assert {name: plane.dtype.str for name, plane in exr.items()} == {"A": "<f2", "B": "<f2", "G": "<f2", "R": "<f2", "Z": "<f4"}
    assert exr["Z"].tobytes() == depth.tobytes()
    alpha = rgba[..., 3] / 255
    numpy.testing.assert_allclose(exr["A"], alpha, rtol=ROUNDING)
    for i, name in enumerate("RGB"):
        numpy.testing.assert_allclose(exr[name], linear(rgba[..., i]) * alpha, rtol=ROUNDING, atol=1e-6)
    primaries = struct.unpack("<8f", head["chromaticities"][1])
    numpy.testing.assert_allclose(primaries, (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329), rtol=1e-6)
    return alpha, depth


def check_refusals(room):
    film = render(f"{room}/film.mp4", "--exr")
    assert (film.returncode, film.stderr) == (2, "ldp render: --exr: a film has no depth: give a folder to -o\n"), film
    stem = pathlib.Path(room, "views", "frame_000")
    stem.with_suffix(".png").unlink()
    stem.with_suffix(".pfm").unlink()
    other = render(f"{room}/views", "--exr")
    assert other.returncode == 2 and "frame_000.exr: is there already and is no view" in other.stderr, other


def main():
    with tempfile.TemporaryDirectory() as room:
        views = pathlib.Path(room, "views")
        done = render(views, "--depth", "--exr", "--layers", "1")
        if "built without OpenEXR" in done.stderr:
            print("exr_check: skipped: built without OpenEXR")
            sys.exit(77)
        assert (done.returncode, done.stderr) == (0, ""), done
        alpha, depth = check_view(views / "frame_000")
        check_view(views / "frame_001")
        assert 0.01 < (alpha == 0).mean() < 0.99 and (depth > 0).any(), "a view with holes, or this shows little"
        again = render(f"{room}/alone", "--exr", "--layers", "1")
        assert again.returncode == 0 and sorted(f.name for f in pathlib.Path(room, "alone").iterdir()) == [
            "frame_000.exr", "frame_000.png", "frame_001.exr", "frame_001.png"]
        assert pathlib.Path(room, "alone/frame_001.exr").read_bytes() == (views / "frame_001.exr").read_bytes()
        check_refusals(room)


main()
