"""Rays of a fisheye camera: pixel <-> azimuth and elevation seen from the robot.

Azimuth is counter-clockwise from the robot's forward, elevation is up from the horizon, both in radians.
In the picture, with x to the right, y down and pixel centres at whole numbers, a ray lies at

    x = cx + r(theta) cos(phi),   y = cy - r(theta) sin(phi),   phi = forward_deg + azimuth,

and at phi = forward_deg - azimuth where the picture is mirrored. Facing up, the optical axis is the zenith and
theta = 90 degrees - elevation. A camera with a mirror above it (facing down-mirror) sees the ground in the middle
of the picture: its optical axis is the nadir and theta = 90 degrees + elevation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.camera.models import FisheyeModel, fisheye_model
from andante.data import CameraSpec, FloatArray
from andante.errors import ConfigError

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class _Lens:
    """A lens model placed in its picture."""

    model: FisheyeModel
    centre_px: tuple[float, float]
    max_theta: float
    rim_px: float

    @classmethod
    def of(cls, spec: CameraSpec) -> _Lens:
        model = fisheye_model(spec)
        if spec.centre_px is None:
            raise ConfigError(
                "the camera declares no centre_px; declare it or find the image circle in some images first "
                "(andante.camera.with_found_circle)"
            )
        if not np.isfinite(spec.centre_px).all():
            raise ConfigError(f"centre_px must be two finite numbers x, y, got {spec.centre_px}")
        rim_px = float(model.radius_px(np.radians(spec.field_of_view_deg / 2.0)))
        # A declared circle smaller than the field of view (a lens hood) hides what lies beyond it.
        if spec.radius_px is not None:
            rim_px = min(rim_px, spec.radius_px)
        return cls(model, spec.centre_px, float(model.theta(rim_px)), rim_px)


def scaled(spec: CameraSpec, scale: float) -> CameraSpec:
    """The same camera for pictures of ``scale`` times the size, for example decoded at half size with 0.5.

    Pixel centres are at whole numbers, so a point x moves to (x + 0.5) scale - 0.5.
    Raises ``ConfigError`` where the scale is not positive.
    """
    if not 0.0 < scale < np.inf:
        raise ConfigError(f"scale must be positive (image pixels per pixel of the camera description), got {scale:g}")
    coefficients = spec.coefficients
    if spec.projection == "ocam":
        coefficients = tuple(a * scale ** (1 - power) for power, a in enumerate(coefficients))
    return replace(
        spec,
        centre_px=spec.centre_px and (_scaled_pixel(spec.centre_px[0], scale), _scaled_pixel(spec.centre_px[1], scale)),
        radius_px=spec.radius_px and spec.radius_px * scale,
        focal_px=spec.focal_px and spec.focal_px * scale,
        coefficients=coefficients,
    )


def project(spec: CameraSpec, azimuth: ArrayLike, elevation: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Where rays meet the picture: (x_px, y_px), NaN outside of the field of view.

    ``azimuth`` and ``elevation`` in radians broadcast against each other; the results have their common shape.
    Raises ``ConfigError`` where the camera is no complete fisheye description.
    """
    lens = _Lens.of(spec)
    theta = _theta(spec, elevation)
    x_px, y_px = _place(spec, lens, azimuth, lens.model.radius_px(np.minimum(theta, lens.max_theta)))
    outside = theta > lens.max_theta + _ROUNDING
    return np.where(outside, np.nan, x_px), np.where(outside, np.nan, y_px)


def project_held(
    spec: CameraSpec, azimuth: ArrayLike, elevation: ArrayLike, margin_px: float
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """As ``project``, but rays beyond ``margin_px`` inside the rim are held there: (x_px, y_px, seen)."""
    lens = _Lens.of(spec)
    theta = _theta(spec, elevation)
    radius = np.minimum(lens.model.radius_px(np.minimum(theta, lens.max_theta)), lens.rim_px - margin_px)
    x_px, y_px = _place(spec, lens, azimuth, radius)
    return x_px, y_px, np.broadcast_to(theta <= lens.max_theta + _ROUNDING, x_px.shape)


def rays(spec: CameraSpec, image_shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """The ray of every pixel of a picture: (azimuth, elevation, valid), each (height, width).

    As ``rays_of_pixels`` of all of them.
    """
    height, width = image_shape[:2]
    return rays_of_pixels(spec, np.arange(width)[None, :], np.arange(height)[:, None])


def rays_of_pixels(
    spec: CameraSpec, x_px: ArrayLike, y_px: ArrayLike
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """The rays of places in a picture, which broadcast against each other: (azimuth, elevation, valid).

    Radians, azimuth in [-pi, pi). ``valid`` is false outside of the image circle, where the elevation is that of the
    rim. The exact inverse of ``project``. Raises ``ConfigError`` where the camera is no complete fisheye description.
    """
    lens = _Lens.of(spec)
    right = np.asarray(x_px, np.float64) - lens.centre_px[0]
    up = lens.centre_px[1] - np.asarray(y_px, np.float64)
    radius = np.hypot(right, up)
    theta = lens.model.theta(np.minimum(radius, lens.rim_px))
    turn = np.arctan2(up, right) - np.radians(spec.forward_deg)
    azimuth = np.mod((-turn if spec.mirrored else turn) + np.pi, 2.0 * np.pi) - np.pi
    elevation = np.pi / 2.0 - theta if spec.facing == "up" else theta - np.pi / 2.0
    return azimuth, elevation, radius <= lens.rim_px * (1.0 + _ROUNDING)


def _scaled_pixel(position: float, scale: float) -> float:
    return (position + 0.5) * scale - 0.5


def _theta(spec: CameraSpec, elevation: ArrayLike) -> FloatArray:
    """Angle off the optical axis."""
    up = np.asarray(elevation, np.float64)
    return np.pi / 2.0 - up if spec.facing == "up" else np.pi / 2.0 + up


def _place(spec: CameraSpec, lens: _Lens, azimuth: ArrayLike, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Image position of a ray at a radius."""
    turn = np.asarray(azimuth, np.float64)
    phi = np.radians(spec.forward_deg) + (-turn if spec.mirrored else turn)
    return lens.centre_px[0] + radius * np.cos(phi), lens.centre_px[1] - radius * np.sin(phi)
