"""A point cloud of all layers within a distance, as .ply, which Open3D, MeshLab and CloudCompare open.

  point_cloud.py room.ldp cloud.ply [METRES]
"""
import sys

import ldp
import numpy as np

HEADER = """ply
format binary_little_endian 1.0
element vertex {}
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
end_header
"""


def write_ply(file, positions, colours):
    points = np.zeros(len(positions), [("position", "<f4", 3), ("colour", "u1", 3)])
    points["position"], points["colour"] = positions, colours
    with open(file, "wb") as output:
        output.write(HEADER.format(len(points)).encode() + points.tobytes())


def main(file, output, farthest="20"):
    panorama = ldp.open(file)
    positions, colours = panorama.points()
    near = np.linalg.norm(positions - panorama.arc.centre, axis=1) < float(farthest)
    write_ply(output, positions[near], colours[near])


if __name__ == "__main__":
    main(*sys.argv[1:])
