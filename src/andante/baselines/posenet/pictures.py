"""From a camera's picture to what the network takes: unwrapped, shrunk, its light evened out."""

from __future__ import annotations

import numpy as np

from andante.data import ImageArray
from andante.features.illumination import Float32Array, Surroundings, patch_normalised, window_px
from andante.mapping import FrontEnd, MapConfig
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording

AZIMUTH_STRIDE = 16
"""Columns of a panorama to a column of the network; only where they come out even do its columns close the circle."""
_LIGHT = MapConfig().features
"""Windows and floor of a map's own patch normalisation serve the network as well."""


def front_end_of(recording: Recording, width_px: int, height_px: int, elevation_deg: tuple[float, float]) -> FrontEnd:
    """What unwraps the pictures of a recording's camera; ``width_px`` is rounded down to ``AZIMUTH_STRIDE``.

    Raises ``RecordingError`` where none can be read.
    """
    camera, shape = camera_and_size(recording)
    low, high = elevation_deg
    # Pictures that need no unwrapping are never enlarged.
    width_px = width_px if camera.model == "fisheye" else min(width_px, shape[1])
    width_px = max(1, width_px // AZIMUTH_STRIDE) * AZIMUTH_STRIDE
    panorama = PanoramaConfig(width_px=width_px, height_px=height_px, min_deg=low, max_deg=high)
    return FrontEnd(camera, shape, panorama, FeatureConfig(kind="flat"))


def evened(panoramas: ImageArray, *, wrap: bool) -> Float32Array:
    """Grey panoramas (n, height, width) uint8 -> local means off, over local deviations (thesis 5.1.1)."""
    window = window_px((panoramas.shape[1], panoramas.shape[2]), _LIGHT.window_share)
    around = Surroundings.of(panoramas.astype(np.float32), window, wrap=wrap)
    return patch_normalised(around, _LIGHT.deviation_floor)
