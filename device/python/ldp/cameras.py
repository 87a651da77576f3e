"""Pinhole cameras with distortion, as transforms.json has them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ldp import _ldp


@dataclasses.dataclass(eq=False)
class Camera:
    """width, height and fl_x fl_y cx cy in pixels (pixel centres at .5), k1 k2 p1 p2 after Brown and Conrady; pose: (4, 4)
    float64, camera to world, axes x right, y up, z back."""

    pose: np.ndarray
    width: int
    height: int
    fl_x: float
    fl_y: float
    cx: float
    cy: float
    k1: float = 0
    k2: float = 0
    p1: float = 0
    p2: float = 0
    name: str = ""

    @classmethod
    def pinhole(cls, pose: np.ndarray, fov: float = 60, size: tuple[int, int] = (800, 600)) -> Camera:
        """fov: horizontal, degrees; size: (width, height)."""
        width, height = size
        if not 0 < fov < 179:
            raise ValueError(f"fov: {fov} degrees must be between 0 and 179")
        focal = width / (2 * math.tan(math.radians(fov) / 2))
        return cls(pose, width, height, focal, focal, width / 2, height / 2)

    @classmethod
    def from_frame(cls, frame: dict, shared: dict | None = None) -> Camera:
        """Of a frame of a transforms.json; `shared`: the file itself, for what all frames have in common."""
        fields = {**(shared or {}), **frame}
        width, height, fl_x = int(fields["w"]), int(fields["h"]), fields["fl_x"]
        return cls(np.asarray(frame["transform_matrix"], float), width, height, fl_x, fields.get("fl_y", fl_x),
                   fields.get("cx", width / 2), fields.get("cy", height / 2),
                   *(fields.get(key, 0) for key in ("k1", "k2", "p1", "p2")), name=frame.get("file_path", ""))

    def as_frame(self) -> dict:
        """What transforms.json holds of it."""
        return {"file_path": self.name, "w": self.width, "h": self.height, "fl_x": self.fl_x, "fl_y": self.fl_y,
                "cx": self.cx, "cy": self.cy, "k1": self.k1, "k2": self.k2, "p1": self.p1, "p2": self.p2,
                "transform_matrix": np.asarray(self.pose).tolist()}

    def _native(self) -> _ldp.Camera:
        lens = [self.fl_x, self.fl_y, self.cx, self.cy, self.k1, self.k2, self.p1, self.p2]
        return _ldp.Camera(self.width, self.height, lens, np.asarray(self.pose, float))

    @classmethod
    def _of(cls, camera: tuple, name: str = "") -> Camera:
        width, height, lens, pose = camera
        return cls(pose, width, height, *lens, name=name)
