"""Every example of device/examples does what its first lines say; what it writes is read back.

  PYTHONPATH=build/release/device/python examples_test.py LDP_PROGRAM EXAMPLES PRINT_LAYER GOLDEN_FOLDER
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from PIL import Image

PROGRAM, EXAMPLES, PRINT_LAYER, GOLDEN = sys.argv[1:5]
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
            if file.suffix in (".py", ".c"):
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


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
