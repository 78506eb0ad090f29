"""Parts of a panorama, as people look at them: a window around a direction, and what of a box it can show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import ImageArray
from andante.landmarks.boxes import Box


def window(panorama: ImageArray, azimuth_rad: float, width_rad: float) -> ImageArray:
    """The part of a panorama (H, W[, 3]) around an azimuth, at full height, also across the seam."""
    around = panorama.shape[1]
    width = int(np.clip(round(width_rad / (2.0 * np.pi) * around), 1, around))
    middle = (np.pi - azimuth_rad) / (2.0 * np.pi) * around
    columns = np.arange(width) + math.floor(middle - width / 2.0 + 0.5)
    return np.asarray(np.take(panorama, np.mod(columns, around), axis=1), np.uint8)


def elevations_rad(geometry: PanoramaGeometry) -> tuple[float, float]:
    """Lowest and highest elevation that a panorama shows."""
    return math.radians(geometry.min_deg), math.radians(geometry.max_deg)


def clipped(box: Box, geometry: PanoramaGeometry) -> Box | None:
    """The part of a box between the lowest and the highest row, ``None`` where there is no such part."""
    lowest, highest = elevations_rad(geometry)
    low, high = max(box.low_rad, lowest), min(box.high_rad, highest)
    return None if low >= high else replace(box, elevation_rad=(low + high) / 2.0, height_rad=high - low)


def visible_share(box: Box, geometry: PanoramaGeometry) -> float:
    """Which share of a box, from 0 to 1, lies between the lowest and the highest row."""
    part = clipped(box, geometry)
    return 0.0 if part is None else part.height_rad / box.height_rad
