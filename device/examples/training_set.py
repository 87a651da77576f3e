"""A training set for nerfstudio and gsplat: the photographs, their cameras and sparse points to start from.

  training_set.py room.ldp photos/ set/          then: ns-train splatfacto --data set/
"""
import json
import pathlib
import shutil
import sys

import ldp
import numpy as np
from PIL import Image
from point_cloud import write_ply

POINTS = 50_000


def main(file, photos, output):
    panorama, images = ldp.open(file), pathlib.Path(output, "images")
    images.mkdir(parents=True)
    frames = []
    for camera in panorama.cameras:
        shutil.copy(pathlib.Path(photos, camera.name), images)
        with Image.open(images / camera.name) as photo:  # panoramas of large photos are made from smaller ones
            scale_x, scale_y = photo.width / camera.width, photo.height / camera.height
        frame = camera.as_frame()
        frame.update(file_path=f"images/{camera.name}", w=round(camera.width * scale_x), h=round(camera.height * scale_y),
                     fl_x=camera.fl_x * scale_x, cx=camera.cx * scale_x, fl_y=camera.fl_y * scale_y, cy=camera.cy * scale_y)
        frames.append(frame)
    positions, colours = panorama.points()
    chosen = np.random.default_rng(1).permutation(len(positions))[:POINTS]
    write_ply(pathlib.Path(output, "sparse_pc.ply"), positions[chosen], colours[chosen])
    description = {"camera_model": "OPENCV", "ply_file_path": "sparse_pc.ply", "frames": frames}
    pathlib.Path(output, "transforms.json").write_text(json.dumps(description, indent=1))


if __name__ == "__main__":
    main(*sys.argv[1:])
