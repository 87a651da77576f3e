"""Every example of device/examples does what its first lines say; what it writes is read back.

  PYTHONPATH=build/release/device/python examples_test.py LDP_PROGRAM EXAMPLES PRINT_LAYER GOLDEN_FOLDER PIPE_CAMERA LDPD [TEST...]

PIPE_CAMERA and LDPD may be empty: what needs them is skipped.
"""
import importlib.util
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

PROGRAM, EXAMPLES, PRINT_LAYER, GOLDEN, PIPE_CAMERA, LDPD = sys.argv[1:7]
FILE = pathlib.Path(GOLDEN) / "uniform_lossless.ldp"


def points_of(file):
    """A strict reader of the header that the examples write."""
    head, body = file.read_bytes().split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    assert lines[3:] == [f"property float {c}" for c in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    points = np.frombuffer(body, [("position", "<f4", 3), ("colour", "u1", 3)])
    assert lines[2] == f"element vertex {len(points)}"
    return points


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.room = pathlib.Path(folder.name)

    def run_example(self, name, *words):
        subprocess.run([sys.executable, f"{EXAMPLES}/{name}", *map(str, words)], check=True)

    def test_are_short(self):
        for file in pathlib.Path(EXAMPLES).iterdir():
            if file.suffix in (".py", ".c", ".cpp"):
                self.assertLess(len(file.read_text().splitlines()), 60, file)

    def test_print_layer(self):
        front = subprocess.run([PRINT_LAYER, FILE, "0"], check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines()
        self.assertEqual({len(line) for line in front}, {100})
        self.assertNotIn(" ", "".join(front))
        self.assertGreater(len(set("".join(front))), 3)
        refused = subprocess.run([PRINT_LAYER, FILE, "7"], text=True, stderr=subprocess.PIPE)
        self.assertEqual((refused.returncode, refused.stderr), (1, "read layer 7: there is no layer 7 of 3\n"))

    def test_film(self):
        self.run_example("film.py", FILE, self.room / "film.webp", "walk")
        with Image.open(self.room / "film.webp") as film:
            self.assertEqual((film.size, film.n_frames), ((480, 360), 30))

    def test_point_cloud(self):
        self.run_example("point_cloud.py", FILE, self.room / "cloud.ply", "5")
        points = points_of(self.room / "cloud.ply")
        self.assertGreater(len(points), 1000)
        distance = np.linalg.norm(points["position"] - [0.5, -0.25, 1.625], axis=1)
        self.assertLess(distance.max(), 5.001)

    def test_training_set(self):
        photos = self.room / "photos"
        photos.mkdir()
        for index in range(3):
            Image.new("RGB", (160, 120)).save(photos / f"frame_00{index}.jpg")
        self.run_example("training_set.py", FILE, photos, self.room / "set")
        written = json.loads((self.room / "set/transforms.json").read_text())
        self.assertEqual([(frame["w"], frame["h"], frame["fl_x"]) for frame in written["frames"]], 3 * [(160, 120, 128)])
        for frame in written["frames"]:
            self.assertTrue((self.room / "set" / frame["file_path"]).exists())
        self.assertGreater(len(points_of(self.room / "set" / written["ply_file_path"])), 1000)

    def test_report_plots(self):
        if importlib.util.find_spec("matplotlib") is None:
            self.skipTest("matplotlib is absent")
        subprocess.run([PROGRAM, "scene", "room", "-o", self.room / "made", "--size", "160x120", "--frames", "6", "--arc",
                        "60", "--no-novel"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([PROGRAM, "build", self.room / "made", "-o", self.room / "a.ldp", "--report", self.room / "a.json"],
                       check=True, stdout=subprocess.DEVNULL)
        self.run_example("report_plots.py", self.room / "a.json", self.room / "plots.png")
        with Image.open(self.room / "plots.png") as plots:
            self.assertGreater(len(set(plots.convert("L").getdata())), 50)
        subprocess.run([PROGRAM, "build", self.room / "none", "-o", self.room / "b.ldp", "--report", self.room / "b.json"],
                       stderr=subprocess.DEVNULL)
        told = subprocess.run([sys.executable, f"{EXAMPLES}/report_plots.py", self.room / "b.json", "x.png"], text=True,
                              stderr=subprocess.PIPE)
        self.assertIn("that build failed: ", told.stderr)

    def test_pipe_camera(self):
        if not PIPE_CAMERA:
            self.skipTest("no pipe_camera is given")
        for name, colour in (("a", "red"), ("b", "blue")):
            Image.new("RGB", (320, 240), colour).save(self.room / f"{name}.jpg")
        subprocess.run([PIPE_CAMERA, f"cat {self.room}/a.jpg {self.room}/b.jpg", self.room / "capture"], check=True,
                       stderr=subprocess.DEVNULL)
        stored = sorted((self.room / "capture").iterdir())
        self.assertEqual([file.read_bytes() for file in stored], [(self.room / f"{name}.jpg").read_bytes() for name in "ab"])

    def test_verdicts(self):
        if not LDPD:
            self.skipTest("ldpd is built without LCM")
        group, port = f"239.255.{random.randrange(256)}.{random.randrange(256)}", random.randrange(20_000, 30_000)
        listener = subprocess.Popen([sys.executable, f"{EXAMPLES}/verdicts.py", f"{group}:{port}", "1"],
                                    stdout=subprocess.PIPE, text=True)
        self.addCleanup(listener.kill)
        while f":{port:04X} " not in pathlib.Path("/proc/net/udp").read_text():
            self.assertIsNone(listener.poll())
        (self.room / "script").write_text("press\nwait 2000\nrelease\n")
        subprocess.run([LDPD, "--once", "--camera", "scene:courtyard?fps=3&frames=8&arc=60&width=160&height=120", "--button",
                        f"script:{self.room}/script", "--status", f"lcm:udpm://{group}:{port}?ttl=0", "-o",
                        self.room / "store"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        said = listener.communicate(timeout=60)[0]
        self.assertRegex(said, r"sweep_000001\S*: (good|fair|sweep again|failed), .*\d s\n  ")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[7:], verbosity=2)  # reasons of skips
