"""The Python package: what it shows is what the program `ldp` writes, to the byte; errors, Ctrl-C, threads.

  PYTHONPATH=build/release/device/python python_test.py LDP_PROGRAM GOLDEN_FOLDER [CLASS...]

Files and Refusals need neither the program nor PIL.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import ldp

PROGRAM, GOLDEN = sys.argv[1], pathlib.Path(sys.argv[2])
BLOCKS = GOLDEN / "whole_strips.ldp"


def pfm(file):
    content = file.read_bytes()
    _, size, scale, rows = content.split(b"\n", 3)
    width, height = map(int, size.split())
    assert float(scale) < 0
    return np.frombuffer(rows, "<f4").reshape(height, width)[::-1]


def rendered(*options):
    """{name: (rgba, depth)} of `ldp render`."""
    from PIL import Image

    with tempfile.TemporaryDirectory() as room:
        subprocess.run([PROGRAM, "render", BLOCKS, "--depth", "-o", f"{room}/views", *options], check=True,
                       stdout=subprocess.DEVNULL)
        return {file.stem: (np.array(Image.open(file)), pfm(file.with_suffix(".pfm")))
                for file in sorted(pathlib.Path(room, "views").glob("*.png"))}


class Files(unittest.TestCase):
    def test_says_what_a_file_holds(self):
        p = ldp.open(BLOCKS)
        self.assertEqual((p.width, p.height, len(p.layers), p.wraps, p.central), (600, 60, 4, True, True))
        self.assertEqual([camera.name for camera in p.cameras], ["frame_000.jpg", "frame_001.jpg", "frame_002.jpg"])
        self.assertEqual(p.metadata["captured_utc"], "2026-01-02T03:04:05Z")
        self.assertEqual(p.quality["psnr_leave_one_out_db"], 24.25)
        self.assertEqual(p.thumbnail[:2], b"\xff\xd8")
        p.verify()

    def test_planes_have_their_shapes_types_and_units(self):
        p = ldp.open(BLOCKS)
        front, behind = p.layers[0], p.layers[1]
        for layer in (front, behind):
            self.assertEqual((layer.depth.shape, layer.depth.dtype), ((60, 600), np.float32))
            self.assertEqual((layer.rgb.shape, layer.rgb.dtype), ((60, 600, 3), np.uint8))
            self.assertEqual((layer.coverage.dtype, layer.disparity.dtype), (np.bool_, np.uint16))
            np.testing.assert_array_equal(layer.coverage, layer.disparity != 65535)
            np.testing.assert_array_equal(layer.coverage, layer.depth > 0)
        self.assertEqual(behind.coverage.sum(), behind.present_pixels)
        at = front.coverage & (front.disparity > 0)
        np.testing.assert_allclose(front.depth[at] * (1.25 * front.disparity[at] / 3825), 1, 1e-6)
        part = behind.read((37, 119))
        np.testing.assert_array_equal(part.depth, behind.depth[:, 37:119])
        np.testing.assert_array_equal(part.rgb, behind.rgb[:, 37:119])

    # From where its rays come, so that nothing hides anything.
    def test_points_project_to_where_a_view_shows_them(self):
        p = ldp.open(BLOCKS)
        camera = p.path("walk", 3, (120, 90), 60)[1]
        camera.pose[:3, 3] = p.arc.centre
        view = p.render(camera)
        positions, colours = p.points([0])
        self.assertEqual((positions.shape[1], colours.shape), (3, (len(positions), 3)))
        x = (positions - camera.pose[:3, 3]) @ camera.pose[:3, :3] * [1, -1, -1]
        x = x[x[:, 2] > 0]
        column = np.floor(camera.fl_x * x[:, 0] / x[:, 2] + camera.cx).astype(int)
        row = np.floor(camera.fl_y * x[:, 1] / x[:, 2] + camera.cy).astype(int)
        seen = (column >= 0) & (column < 120) & (row >= 0) & (row < 90)
        nearest = np.full((90, 120), np.inf)
        np.minimum.at(nearest, (row[seen], column[seen]), x[seen, 2])
        hit = np.isfinite(nearest) & (view.alpha == 255)
        self.assertGreater(hit.sum(), 1000)
        self.assertGreater(np.mean(np.abs(view.depth[hit] / nearest[hit] - 1) < 0.1), 0.8)

    def test_a_file_is_written_and_read_again(self):
        p = ldp.open(GOLDEN / "uniform_lossless.ldp")
        with tempfile.TemporaryDirectory() as room:
            file = pathlib.Path(room, "a.ldp")
            ldp.save(file, p, p.layers, quality=101, block_px=0, metadata={"device": "a test"})
            again = ldp.open(file)
        self.assertEqual(again.metadata["device"], "a test")
        for a, b in zip(p.layers, again.layers):
            np.testing.assert_array_equal(a.rgb, b.rgb)
            np.testing.assert_array_equal(a.coverage, b.coverage)


class Views(unittest.TestCase):
    def test_are_those_of_the_program_to_the_byte(self):
        p = ldp.open(BLOCKS)
        for fill in ("none", "background"):
            expected = rendered("--path", "sway", "--frames", "3", "--size", "160x120", "--fill", fill)
            for camera in p.path("sway", 3, (160, 120)):
                view = p.render(camera, fill=fill, threads=2)
                rgba, depth = expected[camera.name]
                np.testing.assert_array_equal(view.rgba, rgba)
                self.assertEqual(view.depth.tobytes(), depth.tobytes())

    def test_of_a_pose_are_those_of_transforms_json(self):
        p = ldp.open(BLOCKS)
        pose = np.round(p.path("dolly", 4, (64, 48))[1].pose, 5)  # as written with few digits
        camera = ldp.Camera.pinhole(pose, fov=60, size=(100, 80))
        camera.name = "view.png"
        with tempfile.TemporaryDirectory() as room:
            file = pathlib.Path(room, "views.json")
            file.write_text(json.dumps({"frames": [camera.as_frame()]}))
            rgba, depth = rendered("--cameras", str(file))["view"]
        view = p.render(pose, fov=60, size=(100, 80))
        np.testing.assert_array_equal(view.rgba, rgba)
        self.assertEqual(view.depth.tobytes(), depth.tobytes())
        self.assertIsNone(p.render(pose, size=(20, 10), depth=False).depth)

    def test_other_threads_go_on_meanwhile(self):
        p = ldp.open(BLOCKS)
        camera = p.path("sway", 1, (3000, 3000), 90)[0]
        counted, ended = [0], threading.Event()

        def count():
            while not ended.is_set():
                counted[0] += 1
                time.sleep(0.0005)

        counter = threading.Thread(target=count)
        counter.start()
        begin = counted[0]
        with_worker = threading.Thread(target=lambda: p.render(camera, threads=1))
        with_worker.start()
        with_worker.join()
        ended.set()
        counter.join()
        self.assertGreater(counted[0] - begin, 5)


class Refusals(unittest.TestCase):
    def test_are_exceptions_of_their_kind_with_words(self):
        with self.assertRaisesRegex(OSError, "no/such.ldp"):
            ldp.open("no/such.ldp")
        with self.assertRaisesRegex(ldp.DamagedError, "open a panorama in memory"):
            ldp.open_bytes(b"no panorama")
        with self.assertRaisesRegex(ldp.LimitError, "36000 pixels"):
            ldp.open(BLOCKS, max_pixels=1000)
        p = ldp.open(BLOCKS)
        with self.assertRaisesRegex(ValueError, "4x4"):
            p.render(np.eye(3))
        with self.assertRaisesRegex(ValueError, "not a rotation"):
            p.render(2 * np.eye(4))
        with self.assertRaisesRegex(ValueError, "fill"):
            p.render(np.eye(4), fill="black")
        with self.assertRaisesRegex(ValueError, "spiral"):
            p.path("spiral")
        with self.assertRaises(ValueError):
            p.layers[0].read((500, 700))


class Builds(unittest.TestCase):
    def setUp(self):
        self.room = tempfile.TemporaryDirectory()
        self.capture = f"{self.room.name}/capture"
        subprocess.run([PROGRAM, "scene", "courtyard", "-o", self.capture, "--size", "160x120", "--frames", "8", "--arc",
                        "70", "--no-novel"], check=True, stdout=subprocess.DEVNULL)

    def tearDown(self):
        self.room.cleanup()

    def build(self, **options):
        return ldp.build(self.capture, program=PROGRAM, cameras=f"{self.capture}/transforms.json", layers=2, iterations=1,
                         **options)

    def test_give_a_panorama_and_tell_how_far_they_are(self):
        told = []
        p = self.build(progress=lambda stage, fraction: told.append((stage, fraction)))
        self.assertEqual(len(p.cameras), 8)
        self.assertGreater(len({stage for stage, _ in told}), 3)
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in told))

    def test_that_cannot_be_done_say_why(self):
        for file in sorted(pathlib.Path(self.capture).glob("frames/*"))[2:]:
            file.unlink()
        with self.assertRaisesRegex(ldp.BuildError, "a panorama needs at least 3") as raised:
            self.build()
        self.assertEqual(raised.exception.status, 1)
        with self.assertRaises(FileNotFoundError):
            ldp.build(self.capture, program="/no/such/program")

    def test_end_when_progress_raises_and_leave_no_file(self):
        def interrupted(stage, fraction):
            raise KeyboardInterrupt

        output = pathlib.Path(self.room.name, "a.ldp")
        with self.assertRaises(KeyboardInterrupt):
            self.build(output=output, progress=interrupted)
        self.assertEqual([file.name for file in output.parent.iterdir()], ["capture"])


class Interrupts(unittest.TestCase):
    # A view that takes long, in an interpreter of its own.
    def test_end_a_view_under_way(self):
        script = (f"import ldp, time\np = ldp.open({str(BLOCKS)!r})\ncamera = p.path('sway', 1, (7000, 7000), 90)[0]\n"
                  "p.render(p.cameras[0])\nprint('ready', flush=True)\nbegin = time.process_time()\ntry:\n  p.render(camera, depth=False, threads=1)\n  print('done')\n"
                  "except KeyboardInterrupt:\n  print('interrupted', time.process_time() - begin)\n")
        child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=os.environ)
        self.assertEqual(child.stdout.readline(), "ready\n")
        time.sleep(0.2)
        child.send_signal(signal.SIGINT)
        outcome, seconds = child.communicate()[0].split()
        self.assertEqual(outcome, "interrupted")
        # Of the processor, of which the whole view took 5 s: however busy the machine is.
        self.assertLess(float(seconds), 2.5)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
