"""Layered depth panoramas (.ldp files).

    import ldp
    p = ldp.open("room.ldp")
    p.layers[0].depth                                  # (height, width) float32
    p.render(p.cameras[3].pose, fov=60, size=(800, 600)).rgb
    ldp.build("photos/", progress=print)               # runs the program `ldp`

Lengths are in the capture's unit (metres where the cameras were estimated), the world is right-handed. A pose is a 4x4
matrix, camera to world, camera axes x right, y up, z back: the transform_matrix of a transforms.json. Arrays are indexed
[row, column] from the top left corner. Any number of threads may use a panorama; the interpreter's lock is released
while the library works, and Ctrl-C stops it.
"""

from ldp._ldp import version as _version
from ldp.building import build
from ldp.cameras import Camera
from ldp.errors import BuildError, DamagedError, Error, LimitError
from ldp.panorama import Arc, Layer, NewLayer, Panorama, Planes, View, open, open_bytes, save

__version__ = _version()
__all__ = ["Arc", "BuildError", "Camera", "DamagedError", "Error", "Layer", "LimitError", "NewLayer", "Panorama", "Planes",
           "View", "build", "open", "open_bytes", "save"]
