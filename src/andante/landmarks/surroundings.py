"""The frames of a recording as large colour panoramas, to look for anchors in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from andante.camera import PanoramaGeometry, with_found_circle
from andante.data import CameraSpec, ImageArray
from andante.errors import ConfigError
from andante.landmarks.panoramas import PanoramaMaker
from andante.protocols import Recording

_LOWEST_DEG, _HIGHEST_DEG = -35.0, 55.0
_WIDEST_PX = 2160
_CIRCLE_IMAGES = 7


class Surroundings:
    """Panoramas BGR (H, W, 3) of a recording by frame index; many threads may ask at once.

    A fisheye is unwrapped from where it begins to see, at most 35 degrees below the horizon, to 55 degrees above. A
    panorama is taken to have square pixels and the horizon in its middle row. Raises ``ConfigError`` for a camera that
    does not see all around, ``ImageError`` where its first picture cannot be read.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        shape = recording.load(recording.infos[0], colour=True).shape
        camera = recording.camera
        if camera.model == "fisheye" and (camera.centre_px is None or camera.radius_px is None):
            chosen = np.unique(np.linspace(0, len(recording.infos) - 1, _CIRCLE_IMAGES).astype(int))
            camera = with_found_circle(camera, [recording.load(recording.infos[index]) for index in chosen])
        self.geometry = surrounding_geometry(camera, (shape[0], shape[1]))
        self._maker = PanoramaMaker(camera, shape, self.geometry)

    def __call__(self, index: int) -> ImageArray:
        """Raises ``ImageError`` for a picture that cannot be read."""
        return self._maker(self._recording.load(self._recording.infos[index], colour=True))


def surrounding_geometry(camera: CameraSpec, image_shape: tuple[int, int]) -> PanoramaGeometry:
    """The panorama that shows all there is to find anchors in, about as fine as the picture, with square pixels."""
    height, width = image_shape
    if camera.model != "fisheye":
        half = min(180.0 * height / width, 90.0)
        shrink = min(_WIDEST_PX / width, 1.0)
        return PanoramaGeometry(max(round(width * shrink), 1), max(round(height * shrink), 1), -half, half)
    reach = camera.field_of_view_deg / 2.0
    low, high = (90.0 - reach, 90.0) if camera.facing == "up" else (-90.0, reach - 90.0)
    low, high = max(low, _LOWEST_DEG), min(high, _HIGHEST_DEG)
    if low >= high:
        raise ConfigError(
            f"anchors stand near the horizon; this camera sees elevations of {low:g} degrees and more only: "
            "use one with a field of view of 180 degrees"
            if camera.facing == "up"
            else f"anchors stand near the horizon; this camera sees elevations up to {high:g} degrees only"
        )
    geometry = PanoramaGeometry(min(round(2.4 * min(height, width)), _WIDEST_PX), 1, low, high)
    return replace(geometry, height_px=max(round(geometry.width_px * (high - low) / 360.0), 1))
