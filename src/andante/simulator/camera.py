"""The simulated robot's camera: which ray every pixel looks along."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from andante.camera import PanoramaGeometry, rays, scaled
from andante.data import CameraModel, CameraSpec, Facing, FloatArray, Projection
from andante.simulator.mesh import FloatArray32
from andante.simulator.settings import Settings

_Pixels = Annotated[int, Field(ge=4, le=4096)]
_Degrees = Annotated[float, Field(ge=-90, le=90)]


class SimulatedCamera(Settings):
    """A camera and the size of its pictures.

    Fisheye: every key of ``CameraSpec`` that a lens has; ``radius_px`` defaults to half the smaller side and the
    centre to the middle of the picture. Panorama: all azimuths, elevations ``min_deg`` to ``max_deg``. Perspective:
    a pinhole that looks forward, ``horizontal_field_of_view_deg`` wide. ``mount_height_m`` is above the ground.
    ``antialias`` takes two rays a pixel where objects end.
    """

    model: CameraModel = "fisheye"
    width_px: _Pixels = 480
    height_px: _Pixels = 480
    mount_height_m: Annotated[float, Field(gt=0, le=5)] = 0.5
    antialias: bool = True
    projection: Projection = "equidistant"
    field_of_view_deg: Annotated[float, Field(gt=0, le=360)] = 180.0
    facing: Facing = "up"
    radius_px: Annotated[float, Field(gt=0)] | None = None
    focal_px: Annotated[float, Field(gt=0)] | None = None
    coefficients: tuple[float, ...] = ()
    forward_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    mirrored: bool = False
    min_deg: _Degrees = -20.0
    max_deg: _Degrees = 40.0
    horizontal_field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = 90.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.min_deg >= self.max_deg:
            raise ValueError(f"min_deg {self.min_deg:g} must be below max_deg {self.max_deg:g}")
        if self.model != "fisheye" and (self.mirrored or self.forward_deg):
            raise ValueError("mirrored and forward_deg are for a fisheye only; leave them out")
        return self

    @property
    def spec(self) -> CameraSpec:
        """What a recording says of this camera."""
        if self.model != "fisheye":
            wide = 360.0 if self.model == "panorama" else self.horizontal_field_of_view_deg
            return CameraSpec(model=self.model, horizontal_field_of_view_deg=wide)
        radius = min(self.width_px, self.height_px) / 2.0
        own_scale = self.focal_px is not None or self.projection == "ocam"
        return CameraSpec(
            model="fisheye",
            projection=self.projection,
            field_of_view_deg=self.field_of_view_deg,
            facing=self.facing,
            centre_px=((self.width_px - 1) / 2.0, (self.height_px - 1) / 2.0),
            radius_px=self.radius_px or (None if own_scale else radius),
            focal_px=self.focal_px,
            coefficients=self.coefficients,
            forward_deg=self.forward_deg,
            mirrored=self.mirrored,
        )


@dataclass(frozen=True, slots=True)
class PixelRays:
    """Unit vectors (height, width, 3) in the robot's frame, and where the picture shows anything (height, width)."""

    directions: FloatArray32
    valid: NDArray[np.bool_]


def pixel_rays(camera: SimulatedCamera, oversampling: int = 1) -> PixelRays:
    """The rays through the centres of all pixels, or of ``oversampling`` x ``oversampling`` parts of each."""
    shape = camera.height_px * oversampling, camera.width_px * oversampling
    if camera.model == "perspective":
        return PixelRays(_pinhole(camera, shape), np.ones(shape, np.bool_))
    if camera.model == "panorama":
        geometry = PanoramaGeometry(shape[1], shape[0], camera.min_deg, camera.max_deg)
        azimuth, elevation = geometry.azimuths_rad()[None, :], geometry.elevations_rad()[:, None]
        return PixelRays(_unit(azimuth, elevation), np.ones(shape, np.bool_))
    azimuth, elevation, valid = rays(scaled(camera.spec, oversampling), shape)
    return PixelRays(_unit(azimuth, elevation), valid)


def _unit(azimuth: FloatArray, elevation: FloatArray) -> FloatArray32:
    flat = np.cos(elevation)
    parts = np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    return np.stack(parts, axis=-1).astype(np.float32)


def _pinhole(camera: SimulatedCamera, shape: tuple[int, int]) -> FloatArray32:
    height, width = shape
    half = np.tan(np.radians(camera.horizontal_field_of_view_deg) / 2.0)
    left = half * (1.0 - 2.0 * (np.arange(width) + 0.5) / width)[None, :]
    up = half * height / width * (1.0 - 2.0 * (np.arange(height) + 0.5) / height)[:, None]
    rays_ = np.stack(np.broadcast_arrays(1.0, left, up), axis=-1)
    return np.asarray(rays_ / np.linalg.norm(rays_, axis=-1, keepdims=True), np.float32)
