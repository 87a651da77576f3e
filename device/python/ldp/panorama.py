"""An open panorama: what it holds, and views of it."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ldp import _ldp
from ldp.cameras import Camera


class Arc(NamedTuple):
    """The circle on which the cameras lay: radius, begin and end of the path (radians)."""

    centre: np.ndarray  # (3,)
    world_from_arc: np.ndarray  # (3, 3), columns u(0), u(pi/2) and the axis n, upwards
    radius: float
    theta_begin: float
    theta_end: float
    closed: bool


class View(NamedTuple):
    """rgb: (height, width, 3) uint8, sRGB; alpha: (height, width) uint8, 0 = hole; depth: (height, width) float32 along
    the camera's forward axis, 0 = nothing, inf = at infinity; None unless asked for."""

    rgb: np.ndarray
    alpha: np.ndarray
    depth: np.ndarray | None

    @property
    def rgba(self) -> np.ndarray:
        """(height, width, 4) uint8."""
        return np.dstack([self.rgb, self.alpha])


class Planes(NamedTuple):
    """What a layer holds, each (height, width): depth float32 (distance of a pixel's point from the arc's cylinder, 0 =
    nothing there, inf = at infinity), disparity uint16 (0 .. 3825, 65535 = nothing), coverage bool, alpha uint8; and rgb
    (height, width, 3) uint8 or None."""

    depth: np.ndarray
    disparity: np.ndarray
    coverage: np.ndarray
    alpha: np.ndarray
    rgb: np.ndarray | None


class Layer:
    """One layer; 0 is the front one. Planes are decoded when asked for, then kept."""

    def __init__(self, file: _ldp.File, index: int) -> None:
        self._file, self._index = file, index
        told = file.layer(index)
        self.block_px: int = told.block_px
        self.present_pixels: int = told.present_pixels

    def read(self, columns: tuple[int, int] | None = None, rgb: bool = True, threads: int = 0) -> Planes:
        """Columns begin <= x < end, or all; only these are decoded."""
        begin, end = columns or (0, 0)
        return Planes(*self._file.planes(self._index, begin, end, rgb, _threads(threads)))

    @functools.cached_property
    def _planes(self) -> Planes:
        return self.read(rgb=False)

    @functools.cached_property
    def rgb(self) -> np.ndarray:
        """(height, width, 3) uint8, sRGB, 0 where nothing is."""
        return self.read().rgb

    @property
    def depth(self) -> np.ndarray:
        """(height, width) float32, see Planes."""
        return self._planes.depth

    @property
    def disparity(self) -> np.ndarray:
        """(height, width) uint16, as stored."""
        return self._planes.disparity

    @property
    def coverage(self) -> np.ndarray:
        """(height, width) bool: there is something."""
        return self._planes.coverage

    @property
    def alpha(self) -> np.ndarray:
        """(height, width) uint8: 0 where nothing is, else the silhouette's opacity."""
        return self._planes.alpha


class Panorama:
    """An open .ldp file; see ldp.open. width, height: of the grid of rays, pixels; layers, front to back; cameras: the
    photographs' ones; arc; quality: figures by name; metadata: texts by name; thumbnail: a JPEG file."""

    def __init__(self, file: _ldp.File) -> None:
        self._file = file
        self._told = told = file.description()
        self.width: int = told.width
        self.height: int = told.height
        self.central: bool = told.central  # rays start at the arc's centre, not on it
        self.wraps: bool = told.wraps  # column `width` is column 0 again
        self.layers: list[Layer] = [Layer(file, index) for index in range(told.layers)]
        self.cameras: list[Camera] = [Camera._of(camera, name) for name, camera in file.cameras()]
        self.quality: dict[str, float] = file.quality()
        self.metadata: dict[str, str] = file.metadata()
        self.arc = Arc(np.array(told.arc_centre), np.array(told.world_from_arc).reshape(3, 3), told.arc_radius,
                       told.theta_begin, told.theta_end, told.arc_closed)

    @property
    def thumbnail(self) -> bytes:
        """A JPEG file, empty where there is none."""
        return self._file.thumbnail()

    def verify(self) -> None:
        """Raises DamagedError unless every checksum and bound of the whole file holds."""
        self._file.verify()

    def render(self, pose: np.ndarray | Camera, fov: float = 60, size: tuple[int, int] = (800, 600), *,
               fill: str = "none", depth: bool = True, layers: int = 0, threads: int = 0) -> View:
        """The view of a camera, pixel by pixel that of `ldp render`.

        pose: (4, 4) camera to world, with the horizontal fov [degrees] and size (width, height); or a Camera, which has
        its own. fill: "none" leaves holes with alpha 0, "background" continues what lies behind. layers: drawn at most, 0
        = all. threads: 0 = one per processor. The first view decodes the file and takes longer."""
        if fill not in ("none", "background"):
            raise ValueError(f'fill: "{fill}" must be "none" or "background"')
        camera = pose if isinstance(pose, Camera) else Camera.pinhole(pose, fov, size)
        return View(*self._file.render(camera._native(), layers, fill == "background", depth, _threads(threads)))

    def path(self, kind: str = "sway", frames: int = 90, size: tuple[int, int] = (800, 600),
             fov: float = 0) -> list[Camera]:
        """Cameras that move through the panorama: "sway", "walk" or "dolly". fov: degrees, 0 = that of the photos."""
        cameras = self._file.path(kind, frames, *size, math.radians(fov))
        return [Camera._of(camera, f"frame_{index:03}") for index, camera in enumerate(cameras)]

    def points(self, layers: Iterable[int] | None = None) -> tuple[np.ndarray, np.ndarray]:
        """World positions (N, 3) float64 and colours (N, 3) uint8 of the pixels of all layers, or of some, that are not at
        infinity."""
        told, chosen = self._told, range(len(self.layers)) if layers is None else layers
        theta = told.theta_left - (np.arange(self.width) + 0.5) * told.theta_pitch
        v = told.v_top - (np.arange(self.height) + 0.5) * told.v_pitch
        u0, u90, axis = self.arc.world_from_arc.T
        outward = np.cos(theta)[:, None] * u0 + np.sin(theta)[:, None] * u90
        begin = 0 if self.central else self.arc.radius
        positions, colours = [], []
        for planes in (self.layers[index].read() for index in chosen):
            rows, columns = np.nonzero(planes.coverage & np.isfinite(planes.depth))
            depth = planes.depth[rows, columns].astype(float)[:, None]
            positions.append(self.arc.centre + (begin + depth) * outward[columns] + depth * v[rows][:, None] * axis)
            colours.append(planes.rgb[rows, columns])
        return np.concatenate(positions), np.concatenate(colours)


@dataclasses.dataclass(frozen=True)
class NewLayer:
    """depth: (height, width) float, 0 = nothing there; rgb: (height, width, 3) uint8; alpha: (height, width) uint8."""

    depth: np.ndarray
    rgb: np.ndarray
    alpha: np.ndarray | None = None


def _threads(asked: int) -> int:
    return asked or min(os.cpu_count() or 1, 256)


def open(path: str | os.PathLike, *, max_pixels: int = 0, max_memory: int = 0) -> Panorama:
    """Opens an .ldp file. max_pixels: of its grid; max_memory: bytes that decoding and views may take; 0 = no limit. A file
    beyond them raises LimitError, one that is damaged DamagedError. Nothing is decoded yet."""
    return Panorama(_ldp.File.open(os.fspath(path), max_pixels, max_memory))


def open_bytes(content: bytes, *, max_pixels: int = 0, max_memory: int = 0) -> Panorama:
    """The same of a file's content."""
    return Panorama(_ldp.File.from_bytes(content, max_pixels, max_memory))


def save(path: str | os.PathLike, like: Panorama, layers: Iterable[Layer | Planes | NewLayer], *, quality: int = 90,
         block_px: int = 16, metadata: Mapping[str, str] | None = None) -> None:
    """Writes an .ldp file of these layers, front to back, on the grid and with the cameras of `like`. quality: of colour, 1
    to 100, 101 = lossless; depths become 4-bit codes in blocks of block_px pixels (those of a file are coded anew, `ldp
    build` takes blocks of 8). The verdict of `like` (quality) and its local exposure are of its own layers and are not
    taken over. The file appears whole or not at all."""
    writer = _ldp.Writer(like._told)
    for layer in layers:
        writer.add_layer(layer.depth, layer.rgb, layer.alpha, block_px)
    for camera in like.cameras:
        writer.add_camera(camera.name, camera._native())
    for name, value in {**like.metadata, **(metadata or {})}.items():
        writer.set_metadata(name, value)
    writer.save(os.fspath(path), quality)
