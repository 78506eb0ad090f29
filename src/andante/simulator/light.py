"""Sun and sky: where the light comes from, how strong it is, and what the sky looks like."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from andante.data import FloatArray
from andante.simulator.conditions import Conditions
from andante.simulator.mesh import FloatArray32, f32
from andante.simulator.noise import lookup, tileable_noise
from andante.simulator.seasons import SEASONS

_DOME_SHAPE = (181, 720)  # elevation 0..90 degrees by azimuth -180..180 degrees
_ZENITH, _HORIZON = f32([0.11, 0.235, 0.56]), f32([0.46, 0.60, 0.80])
_WHITE, _GREY = f32([0.86, 0.87, 0.89]), f32([0.50, 0.52, 0.56])


@dataclass(frozen=True, slots=True)
class Light:
    """Light at one moment: unit vector to the sun (3,), irradiance of sun and sky (3,) each, linear RGB."""

    to_sun: FloatArray32
    sun: FloatArray32
    sky: FloatArray32
    brightness: float


def light_at(conditions: Conditions, share: float) -> Light:
    """The light after ``share`` (0..1) of a recording.

    The sun stands in the direction of a lamp (x, y, z) that moves along x with the hour; y is ``sun_y_m`` (thesis 4.1),
    z falls with the distance from noon and with the season.
    """
    hour = conditions.hour + share * conditions.drift_hours
    angle = (hour - 12.0) / 12.0 * np.pi
    height = SEASONS[conditions.season].sun_height_m * max(float(np.cos(angle)), 0.12)
    lamp = np.array([-11.0 * np.sin(angle), conditions.sun_y_m, height])
    strength = conditions.sun_energy / 5.5 * (1.0 + share * conditions.drift_energy)
    through = 0.04 if conditions.overcast else 1.0 - 0.35 * conditions.clouds
    colour = f32([0.25 + conditions.sun_red, 0.98, 0.86])
    return Light(
        f32(lamp / np.linalg.norm(lamp)),
        f32(colour * strength * through * 2.3),
        f32(f32([0.56, 0.63, 0.74]) * (0.45 + 0.4 * strength) * (1.1 if conditions.overcast else 1.0)),
        0.5 + 0.5 * strength,
    )


class Sky:
    """A dome of sky with clouds, fixed for a recording; the clouds follow from ``rng``."""

    def __init__(self, conditions: Conditions, rng: np.random.Generator) -> None:
        rows, columns = _DOME_SHAPE
        elevation = np.linspace(0.0, np.pi / 2.0, rows)[:, None]
        azimuth = np.linspace(-np.pi, np.pi, columns, endpoint=False)[None, :]
        x, y = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth)
        z = np.broadcast_to(np.sin(elevation), x.shape)
        fade = ((1.0 - z) ** 3.5)[..., None]
        blue = _ZENITH * (1.0 - fade) + _HORIZON * fade
        cover, shade = _clouds(x / (z + 0.16), y / (z + 0.16), conditions, rng)
        white = _WHITE * shade[..., None] + _GREY * (1.0 - shade[..., None])
        dome = blue * (1.0 - cover[..., None]) + white * cover[..., None]
        sun = light_at(conditions, 0.0).to_sun
        towards = np.clip(x * sun[0] + y * sun[1] + z * sun[2], 0.0, 1.0)
        glow = (0.55 * towards**24 + 4.0 * towards**900) * (0.06 if conditions.overcast else 1.0)
        dome = dome + glow[..., None] * f32([1.0, 0.95, 0.8])
        self.horizon = np.asarray(dome[: rows // 24].mean(axis=(0, 1)), np.float32)
        # One more column on the right closes the circle for the interpolation.
        self._dome = np.concatenate([dome, dome[:, :1]], axis=1).astype(np.float32)

    def look(self, directions: FloatArray32) -> FloatArray32:
        """Linear RGB (k, 3) along unit directions (k, 3); below the horizon that of the horizon."""
        if not len(directions):
            return np.empty((0, 3), np.float32)
        rows, columns = _DOME_SHAPE
        azimuth = np.arctan2(directions[:, 1], directions[:, 0])
        column = (azimuth + np.float32(np.pi)) * np.float32(columns / (2.0 * np.pi))
        flat = np.sqrt(directions[:, 0] ** 2 + directions[:, 1] ** 2)
        row = np.arctan2(np.maximum(directions[:, 2], 0.0), flat) * np.float32((rows - 1) / (np.pi / 2.0))
        return _sampled(self._dome, column.astype(np.float32), row.astype(np.float32))


def _sampled(dome: FloatArray32, column: FloatArray32, row: FloatArray32) -> FloatArray32:
    """Bilinear samples; in rows of 1024, because OpenCV takes no map longer than 32767."""
    count = len(column)
    padded = -(-count // 1024) * 1024
    maps = [np.pad(values, (0, padded - count)).reshape(-1, 1024) for values in (column, row)]
    colours = cv2.remap(dome, maps[0], maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(colours.reshape(-1, 3)[:count], np.float32)


def _clouds(
    x: FloatArray, y: FloatArray, conditions: Conditions, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """How much cloud covers (x, y) of a plane overhead, and how bright it is there; both 0..1."""
    form, detail = tileable_noise(rng, 256, 1.75), tileable_noise(rng, 256, 1.3, 4.0)
    u, v = rng.random(2)
    density = lookup(form, x / 9.0 + u, y / 9.0 + v) + 0.35 * lookup(detail, x / 5.0 + v, y / 5.0 + u)
    if conditions.overcast:
        return np.full(x.shape, 0.97), np.clip(0.45 + 0.12 * density, 0.0, 1.0)
    threshold = 1.5 - 2.6 * conditions.clouds
    cover = np.clip((density - threshold) / 0.9, 0.0, 1.0) ** 0.8
    return cover * min(1.0, 8.0 * conditions.clouds), np.clip(0.95 - 0.18 * (density - threshold), 0.35, 1.0)
