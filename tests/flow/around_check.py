#!/usr/bin/env python3
"""Panoramas seen from a place, held against the scene itself: omnidirectional stereo, and depth as exiftool finds it.

  around_check.py LDP [-o FOLDER]      LDP: the program. FOLDER keeps what was compared
"""
import argparse
import io
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy
from PIL import Image

SWEEP = ["--size", "480x360", "--frames", "16", "--arc", "150", "--jitter-position", "0", "--jitter-angle", "0"]
LEAST_STEREO_DB = 27
LEAST_SHARE_WITHIN_A_LABEL = 0.85
LABELS = 16
EYE_HEIGHT_M = 1.6  # of the scenes' sweeps


def psnr_db(a, b, where=True):
    error = ((a.astype(float) - b.astype(float)) ** 2).mean(axis=2)
    return 10 * numpy.log10(255 ** 2 / numpy.mean(error, where=where))


def xmp(file, *tags):
    """Values of tags by name, as exiftool reads them."""
    said = subprocess.run(["exiftool", "-json", "-n", *["-" + tag for tag in tags], file], check=True, capture_output=True)
    return json.loads(said.stdout)[0]


class Rendered:
    """A sweep without jitter, so that its arc is known, its panorama, and what is exported and traced in one frame."""

    def __init__(self, program, folder):
        self.folder = pathlib.Path(folder)
        self.ldp = lambda *words: subprocess.run([program, *map(str, words)], check=True, capture_output=True, text=True).stdout
        sweep, self.file = self.folder / "sweep", self.folder / "room.ldp"
        self.ldp("scene", "room", "-o", sweep, *SWEEP, "--no-novel")
        self.ldp("build", sweep, "--cameras", sweep / "transforms.json", "-o", self.file)
        self.info = json.loads(self.ldp("info", "--json", self.file))
        for name, kind in (("stereo.png", "stereo"), ("depth.jpg", "depth"), ("depth.png", "depth"), ("one.png", "panorama")):
            self.ldp("export", self.file, "--kind", kind, "-o", self.folder / name)
        self.ldp("export", self.file, "-o", str(self.folder / "layers") + "/")
        self.place = xmp(self.folder / "depth.jpg", "XMP-GPano:all")
        self.width = self.place["FullPanoWidthPixels"]
        self.ldp("scene", "room", "-o", self.folder / "truth", "--frames", 2, "--size", "32x24", "--no-novel", "--around", self.width,
                 "--heading", self.heading_deg())

    def heading_deg(self):
        """Where the panorama's middle looks, to the right of the sweep's (+y)."""
        grid = json.loads((self.folder / "layers" / "layers.json").read_text())["grid"]
        theta = grid["theta_left"] - grid["width"] / 2 * grid["theta_pitch"]
        x, y, _ = numpy.cos(theta) * numpy.array(grid["arc_u0"]) + numpy.sin(theta) * numpy.array(grid["arc_u90"])
        return numpy.degrees(numpy.arctan2(x, y))

    def picture(self, name):
        return numpy.asarray(Image.open(self.folder / name).convert("RGB"))

    def true(self, name):
        return self.picture("truth/around/" + name)

    def band(self, sphere):
        """The part of a sphere that the panorama shows."""
        top, left = self.place["CroppedAreaTopPixels"], self.place["CroppedAreaLeftPixels"]
        return sphere[top:top + self.place["CroppedAreaImageHeightPixels"], left:left + self.place["CroppedAreaImageWidthPixels"]]

    def true_distance(self):
        return self.band(numpy.load(self.folder / "truth/around/distance.npy").astype(float))

    def angles(self):
        """Of the band's pixels: theta of the scene's world, elevation."""
        pitch = 2 * numpy.pi / self.width
        rows, columns = self.place["CroppedAreaImageHeightPixels"], self.place["CroppedAreaImageWidthPixels"]
        elevation = numpy.pi / 2 - (numpy.arange(rows) + self.place["CroppedAreaTopPixels"] + 0.5) * pitch
        right = (numpy.arange(columns) + self.place["CroppedAreaLeftPixels"] + 0.5) * pitch - numpy.pi
        return numpy.pi / 2 - numpy.radians(self.heading_deg()) - right[None, :], elevation[:, None]

    def inverse_depth(self, distance):
        """Of the panorama's rays: horizontally, from the arc on."""
        return 1 / (distance * numpy.cos(self.angles()[1]) - self.info["arc"]["radius"])

    def taken_in(self):
        """Where what is to be seen lies within the frames of two photographs or more: what one alone shows may have any depth."""
        theta, elevation = self.angles()
        distance = numpy.minimum(self.true_distance(), 1e4)
        points = numpy.stack([distance * numpy.cos(elevation) * numpy.cos(theta), distance * numpy.cos(elevation) * numpy.sin(theta),
                              EYE_HEIGHT_M + distance * numpy.sin(elevation)], axis=-1)
        told = json.loads((self.folder / "sweep" / "transforms.json").read_text())
        taken = numpy.zeros(distance.shape, int)
        for frame in told["frames"]:
            pose = numpy.array(frame["transform_matrix"])
            x, y, z = numpy.moveaxis((points - pose[:3, 3]) @ pose[:3, :3], -1, 0)  # right, up, back
            with numpy.errstate(divide="ignore", invalid="ignore"):
                u, v = told["cx"] - told["fl_x"] * x / z, told["cy"] + told["fl_y"] * y / z
            taken += (z < 0) & (u > 0) & (u < told["w"]) & (v > 0) & (v < told["h"])
        return taken >= 2


def check_stereo(rendered):
    """Both eyes against both traced, and that they are not exchanged."""
    ours, true = rendered.picture("stereo.png"), rendered.true("stereo.png")
    assert ours.shape == true.shape == (rendered.width, rendered.width, 3), (ours.shape, true.shape)
    half = rendered.width // 2
    taken = rendered.taken_in()
    eyes = [(rendered.band(ours[i:i + half]), rendered.band(true[i:i + half])) for i in (0, half)]
    found = [psnr_db(a, b, taken) for a, b in eyes]
    exchanged = psnr_db(eyes[0][0], eyes[1][1], taken)
    print("stereo against the scene, in the %.0f %% that two photographs take in: left %.1f, right %.1f dB; exchanged %.1f dB; everywhere %.1f dB"
          % (100 * numpy.mean(taken), *found, exchanged, psnr_db(*eyes[0])))
    assert min(found) >= LEAST_STEREO_DB, "at least %d dB" % LEAST_STEREO_DB
    assert exchanged < min(found) - 2, "the eyes see the same"


def depth_of_jpeg(rendered):
    """Distances from the picture inside the JPEG, by the formula of GDepth."""
    file = rendered.folder / "depth.jpg"
    told = xmp(file, "XMP-GDepth:Format", "XMP-GDepth:Near", "XMP-GDepth:Far", "XMP-GDepth:Mime", "XMP-GDepth:MeasureType")
    assert (told["Format"], told["Mime"], told["MeasureType"]) == ("RangeInverse", "image/png", "OpticRay"), told
    inside = subprocess.run(["exiftool", "-b", "-XMP-GDepth:DepthImage", file], check=True, capture_output=True).stdout
    share = numpy.asarray(Image.open(io.BytesIO(inside))).astype(float) / 65535
    return told["Far"] * told["Near"] / (told["Far"] - share * (told["Far"] - told["Near"])), inside


def check_depth(rendered):
    distance, inside = depth_of_jpeg(rendered)
    alone = numpy.asarray(Image.open(rendered.folder / "depth.png"))
    assert alone.dtype.itemsize > 1 and (alone == numpy.asarray(Image.open(io.BytesIO(inside)))).all(), "both files tell the same"
    true = rendered.true_distance()
    assert distance.shape == true.shape == rendered.picture("depth.jpg").shape[:2]
    grid = rendered.info["grid"]
    far = 0 if grid["farthest_depth"] == "infinity" else 1 / grid["farthest_depth"]
    label = (1 / grid["nearest_depth"] - far) / (LABELS - 1)
    apart = numpy.abs(rendered.inverse_depth(distance) - rendered.inverse_depth(true))
    within = numpy.mean(apart <= label, where=rendered.taken_in())
    print("depth within a label: %.1f %%" % (100 * within))
    assert within >= LEAST_SHARE_WITHIN_A_LABEL


def check_the_picture_is_that_of_one_eye(rendered):
    found = psnr_db(rendered.picture("depth.jpg"), rendered.picture("one.png"))
    true = psnr_db(rendered.picture("one.png"), rendered.band(rendered.true("panorama.png")), rendered.taken_in())
    print("the picture with depth against the one without: %.1f dB; against the scene %.1f dB" % (found, true))
    assert found > 35 and true >= LEAST_STEREO_DB


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ldp")
    parser.add_argument("-o", dest="folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ldp_around_") as folder:
        kept = pathlib.Path(arguments.folder or folder)
        kept.mkdir(parents=True, exist_ok=True)
        rendered = Rendered(arguments.ldp, kept)
        check_stereo(rendered)
        check_depth(rendered)
        check_the_picture_is_that_of_one_eye(rendered)
    return 0


if __name__ == "__main__":
    sys.exit(main())
