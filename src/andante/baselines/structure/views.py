"""How COLMAP is shown a fisheye picture: all of it, or a pinhole view cut from its middle.

COLMAP knows few lenses, and hardly any up to the rim. Key points are therefore found in the picture as it is and then
moved to where an ideal equidistant lens (its SIMPLE_FISHEYE, r = f theta, below 90 degrees off axis) would have seen
the same ray, which the camera model of Andante tells. So every lens is understood exactly and nothing is resampled.

How far from the zenith matters more than all else: in a rendered garden a map of what lies up to 60 degrees off axis
localizes one frame in eight, up to 80 degrees all of them, and each degree towards the horizon helps in other seasons.

A camera frame has its third axis along the optical axis and its first along the robot's forward.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.baselines.structure.library import colmap
from andante.camera import fisheye_model, project, rays_of_pixels
from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import ConfigError

if TYPE_CHECKING:
    import pycolmap

_RIM_PX = 3.0
"""So near to the end of the picture the end itself is what a key point describes."""
_FAR_PX = 1e6
_LARGEST_DEG = 89.5
"""COLMAP's fisheye lenses see nothing at 90 degrees off axis."""


class View(Protocol):
    """Pictures and pixels of a camera as COLMAP's ``model`` with ``params`` and ``size`` (width, height) takes them."""

    @property
    def model(self) -> str:
        """COLMAP's name of the lens."""
        ...

    @property
    def params(self) -> tuple[float, ...]:
        """Focal length and principal point in pixels; COLMAP has pixel centres at halves."""
        ...

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        ...

    @property
    def robot_from_camera(self) -> FloatArray:
        """(3, 3) rotation."""
        ...

    def picture(self, image: ImageArray) -> ImageArray:
        """The grey picture in which key points are looked for."""
        ...

    def points(self, xy: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Pixels (k, 2) of ``picture``, centres at whole numbers -> COLMAP's pixels (k, 2) and (k,) which to keep."""
        ...


def colmap_camera(view: View) -> pycolmap.Camera:
    """A ``pycolmap.Camera`` whose intrinsics are known."""
    library = colmap()
    width, height = view.size
    camera: pycolmap.Camera = library.Camera(model=view.model, width=width, height=height, params=list(view.params))
    camera.has_prior_focal_length = True
    return camera


def axes_of(spec: CameraSpec) -> FloatArray:
    """Rotation (3, 3) from the camera to the robot: the optical axis is the zenith, or the nadir with a mirror."""
    return np.diag([1.0, 1.0, 1.0] if spec.facing == "up" else [1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True)
class FisheyeView:
    """The picture as it is, up to ``limit_deg`` off the optical axis."""

    spec: CameraSpec
    limit_deg: float
    model: str = field(default="SIMPLE_FISHEYE", init=False)

    @classmethod
    def of(cls, spec: CameraSpec, limit_deg: float) -> FisheyeView:
        """Raises ``ConfigError`` where the camera is no complete fisheye description or the limit out of range."""
        if not 0.0 < limit_deg <= _LARGEST_DEG:
            raise ConfigError(f"limit_deg must be above 0 and at most {_LARGEST_DEG:g}, got {limit_deg:g}")
        fisheye_model(spec)
        return cls(spec, min(limit_deg, spec.field_of_view_deg / 2.0))

    @property
    def _focal_px(self) -> float:
        """Pixels per radian: those of the lens between its centre and the limit."""
        limit = np.radians(self.limit_deg)
        return float(fisheye_model(self.spec).radius_px(limit) / limit)

    @property
    def _rim_rad(self) -> float:
        """Where the picture ends, which is the ray that pixels outside of it are given."""
        _, elevation, _ = rays_of_pixels(self.spec, -_FAR_PX, 0.0)
        return float(np.pi / 2.0 - (elevation if self.spec.facing == "up" else -elevation))

    @property
    def params(self) -> tuple[float, ...]:
        """See ``View``."""
        return self._focal_px, self.size[0] / 2.0, self.size[1] / 2.0

    @property
    def size(self) -> tuple[int, int]:
        """See ``View``."""
        side = 2 * int(np.ceil(self._focal_px * np.pi / 2.0))
        return side, side

    @property
    def robot_from_camera(self) -> FloatArray:
        """See ``View``."""
        return axes_of(self.spec)

    def picture(self, image: ImageArray) -> ImageArray:
        """See ``View``."""
        return np.ascontiguousarray(image)

    def points(self, xy: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See ``View``."""
        azimuth, elevation, seen = rays_of_pixels(self.spec, xy[:, 0], xy[:, 1])
        facing = 1.0 if self.spec.facing == "up" else -1.0
        theta = np.pi / 2.0 - facing * elevation
        focal_px, cx, cy = self.params
        # Seen along a downward axis, counter-clockwise from above turns the other way.
        moved = np.column_stack([np.cos(azimuth), facing * np.sin(azimuth)]) * (focal_px * theta)[:, None] + (cx, cy)
        return moved, seen & (theta <= min(np.radians(self.limit_deg), self._rim_rad - _RIM_PX / focal_px))


@dataclass(frozen=True, slots=True)
class PinholeView:
    """The middle of the picture as a pinhole camera would see it (thesis 8.1).

    ``map_x, map_y`` (side, side) float32 say where its pixels lie in the picture.
    """

    spec: CameraSpec
    focal_px: float
    map_x: NDArray[np.float32] = field(repr=False)
    map_y: NDArray[np.float32] = field(repr=False)
    model: str = field(default="SIMPLE_PINHOLE", init=False)

    @classmethod
    def of(cls, spec: CameraSpec, field_of_view_deg: float) -> PinholeView:
        """As sharp in its centre as the picture; raises ``ConfigError`` for a field of view the lens does not have."""
        widest = min(spec.field_of_view_deg, 170.0)
        if not 0.0 < field_of_view_deg <= widest:
            raise ConfigError(f"field_of_view_deg must be above 0 and at most {widest:g}, got {field_of_view_deg:g}")
        lens, small = fisheye_model(spec), 1e-3
        focal_px = float(lens.radius_px(small) / small)
        half = np.tan(np.radians(field_of_view_deg / 2.0))
        side = max(1, round(2.0 * focal_px * half))
        focal_px = side / (2.0 * half)
        across = np.arange(side) + 0.5 - side / 2.0
        rays_cam = np.stack([*np.meshgrid(across, across), np.full((side, side), focal_px)], axis=-1)
        x, y, z = np.moveaxis(rays_cam @ axes_of(spec).T, -1, 0)
        map_x, map_y = project(spec, np.arctan2(y, x), np.arctan2(z, np.hypot(x, y)))
        nowhere = -2.0  # outside of the picture, which remap paints black
        map_x, map_y = np.nan_to_num(map_x, nan=nowhere), np.nan_to_num(map_y, nan=nowhere)
        return cls(spec, focal_px, map_x.astype(np.float32), map_y.astype(np.float32))

    @property
    def params(self) -> tuple[float, ...]:
        """See ``View``."""
        return self.focal_px, self.size[0] / 2.0, self.size[1] / 2.0

    @property
    def size(self) -> tuple[int, int]:
        """See ``View``."""
        return self.map_x.shape[1], self.map_x.shape[0]

    @property
    def robot_from_camera(self) -> FloatArray:
        """See ``View``."""
        return axes_of(self.spec)

    def picture(self, image: ImageArray) -> ImageArray:
        """See ``View``; black where the lens sees nothing."""
        return np.asarray(cv2.remap(image, self.map_x, self.map_y, cv2.INTER_LINEAR), np.uint8)

    def points(self, xy: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """See ``View``."""
        return xy + 0.5, np.ones(len(xy), np.bool_)
