"""From a camera's picture to what the network takes: unwrapped, shrunk, its light evened out."""

from __future__ import annotations

import numpy as np

from andante.data import ImageArray
from andante.features.illumination import Float32Array, Surroundings, patch_normalised, window_px
from andante.mapping import FrontEnd, MapConfig
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording

_LIGHT = MapConfig().features
"""Windows and floor of a map's own patch normalisation serve the network as well."""


def front_end_of(recording: Recording, width_px: int, height_px: int, elevation_deg: tuple[float, float]) -> FrontEnd:
    """What unwraps the pictures of a recording's camera; raises ``RecordingError`` where none can be read."""
    low, high = elevation_deg
    panorama = PanoramaConfig(width_px=width_px, height_px=height_px, min_deg=low, max_deg=high)
    return FrontEnd(*camera_and_size(recording), panorama, FeatureConfig(kind="flat"))


def evened(panoramas: ImageArray, *, wrap: bool) -> Float32Array:
    """Grey panoramas (n, height, width) uint8 -> local means off, over local deviations (thesis 5.1.1)."""
    window = window_px((panoramas.shape[1], panoramas.shape[2]), _LIGHT.window_share)
    around = Surroundings.of(panoramas.astype(np.float32), window, wrap=wrap)
    return patch_normalised(around, _LIGHT.deviation_floor)
